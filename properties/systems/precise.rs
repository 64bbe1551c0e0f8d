//! Files against reference values of other programs: the heavy top by formulas, and systems on structure constants in 32 digits.

use euler_poincare::scalar::{Dd, Number, Real, Scalar};
use euler_poincare::system::Compiled;

#[track_caller]
fn last<T: Compiled>(text: &str) -> Vec<T> {
    super::last(&super::parsed(text))
}

/// A heavy top with drag, all of it by formulas.
const TOP: &str = include_str!("cases/formulas.toml");

/// The potential by a formula beside an inertia, and by its kind, with the drag by its kind.
const WRITTEN: [&str; 2] = [
    "inertia = [\"1/2\", 2, 1]\n[[potential]]\nkind = \"formula\"\nvalue = \"weight*dot(r, Gamma)\"",
    "inertia = [\"1/2\", 2, 1]\n[[potential]]\nkind = \"gravity\"\nweight = \"1.3\"\ncenter = [\"0.3\", \"-0.2\", \"0.5\"]\n\
     [[force]]\nkind = \"linear-drag\"\nmatrix = [[\"0.1\", 0, 0], [0, \"0.3\", 0], [0, 0, \"0.2\"]]",
];

/// μ after a step of 1/8.
const STEP: [f64; 3] = [0.56406502, 0.36518586, 0.81533845];

/// g after a step of 1/8, by rows.
const TURNED: [f64; 9] =
    [0.90742819, -0.37704492, -0.18550256, 0.23446714, 0.82066192, -0.52109421, 0.34871082, 0.42936132, 0.83309641];

/// μ after 20 steps of 1/10.
const LATER: [f64; 3] = [0.86285617, -0.46046665, -0.31754545];

/// Half a unit of the eighth digit, in which the values above are rounded, and what an `f64` adds.
const DIGITS: f64 = 5.1e-9;

#[track_caller]
fn agree<T: Real>(found: &[T], known: &[f64]) {
    let off = found.iter().zip(known).fold(0.0, |m: f64, (a, b)| m.max((a.to_f64() - b).abs()));
    assert!(found.len() == known.len() && off < DIGITS, "{found:?}: off by {off:e}");
}

/// One step and twenty, in one scalar.
fn has_the_reference_values<T: Compiled>(text: &str) {
    // t, μ, η, energy, work, balance, the Casimir, g.
    let row = last::<T>(text);
    agree(&row[1..4], &STEP);
    agree(&row[11..20], &TURNED);
    let longer = text.replacen("step = \"1/8\"\nsteps = 1\n", "step = \"1/10\"\nsteps = 20\n", 1);
    assert_ne!(text, longer);
    agree(&last::<T>(&longer)[1..4], &LATER);
}

#[test]
fn a_file_of_formulas_has_the_reference_values_of_the_heavy_top() {
    let (start, end) = (TOP.find("formula =").unwrap(), TOP.find("[method]").unwrap());
    let by_kind = format!("{}{}\n{}", &TOP[..start], WRITTEN[1], &TOP[end..]);
    let whole = TOP.lines().find(|line| line.starts_with("formula =")).unwrap();
    for text in [TOP.to_owned(), TOP.replacen(whole, WRITTEN[0], 1), by_kind] {
        has_the_reference_values::<f64>(&text);
        has_the_reference_values::<Dd>(&text);
    }
}

/// Systems on structure constants, those of su(3) in the basis of Gell-Mann (1962, table II), that move for half a unit of time. At the end are
/// the momenta by Taylor series of the equations of motion in 64 digits (70 terms; 8 steps and 12 agree to 1e-58), by another program.
const MOVING: [&str; 4] = [
    include_str!("cases/su3-cubic-drag.toml"),
    include_str!("cases/oscillator.toml"),
    include_str!("cases/sl2-drag.toml"),
    include_str!("cases/su3-double-bracket.toml"),
];

#[test]
fn files_on_structure_constants_have_the_reference_values_to_28_digits() {
    for text in MOVING {
        let row = last::<Dd>(text);
        let momentum = text.lines().find_map(|line| line.strip_prefix("# at the end: ")).unwrap();
        for (k, known) in momentum.split(' ').enumerate() {
            let known: Dd = Number::parse(known).unwrap().eval().unwrap();
            let error = (row[1 + k] - known).to_f64().abs();
            assert!(error < 1e-28, "{text:.60}: component {} is off by {error:e}", k + 1);
        }
    }
}

/// A body that quadratic drag slows down, about a fixed axis: μ = 1/(1 + t), turned by log(1 + t).
const SLOWING: &str = include_str!("cases/slowing.toml");

#[test]
fn a_file_in_32_digits_has_them() {
    let row = last::<Dd>(SLOWING);
    let (cosine, sine) = (
        "0.7692389013639721265783299936612707014408959949119638531698715074290813",
        "0.6389612763136348011500329114647017842572305378305797294955869566463245",
    );
    // t, μ, η, the energy, the work, the balance, the Casimir, g by rows.
    let known = [(0, "1"), (3, "1/2"), (6, "1/2"), (7, "1/8"), (8, "-3/8"), (11, cosine), (14, sine), (15, cosine)];
    for (column, known) in known {
        let known: Dd = Number::parse(known).unwrap().eval().unwrap();
        let error = (row[column] - known).to_f64().abs();
        assert!(error < 1e-30, "column {column} is off by {error:e}");
    }
}
