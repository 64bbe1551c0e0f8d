//! How many cases of each law are checked in a second, on a thread.

use euler_poincare::harness::Line;

/// Cases per second of checking; none where there is nothing to divide.
pub fn rate(line: &Line) -> Option<f64> {
    (line.cases > 0 && line.seconds > 0.0).then(|| line.cases as f64 / line.seconds)
}

/// `0.52`, `7.1`, `340`, `12000`: two digits or all before the point.
pub fn text(rate: f64) -> String {
    match rate {
        r if r < 0.995 => format!("{r:.2}"),
        r if r < 99.5 => format!("{r:.1}"),
        r => format!("{r:.0}"),
    }
}
