//! The solutions at T, to some twenty-five digits: `references.txt`, written by `src/bin/reference.rs`.

use crate::problem::{LARGEST, State, System};

/// One line for each problem: the system, T, the components.
const STORED: &str = include_str!("references.txt");

/// The components of the stored solution, as they are spelt.
pub fn digits(system: System, end: f64) -> Option<Vec<&'static str>> {
    STORED.lines().filter(|line| !line.starts_with('#')).find_map(|line| {
        let mut words = line.split_whitespace();
        let found = words.next()? == system.name() && words.next()?.parse() == Ok(end);
        found.then(|| words.collect())
    })
}

/// The stored solution, rounded; none if there is no such line or a number is missing.
pub fn stored(system: System, end: f64) -> Option<State> {
    let digits = digits(system, end)?;
    let mut state = [0.0; LARGEST];
    for (x, text) in state.iter_mut().zip(&digits) {
        *x = text.parse().ok()?;
    }
    (digits.len() == system.numbers()).then_some(state)
}
