//! Files against reference values of other programs: the heavy top by formulas, and systems on structure constants in 32 digits.

use euler_poincare::scalar::{Dd, Number, Real, Scalar};
use euler_poincare::system::Compiled;

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

/// A system on structure constants that moves for half a unit of time.
struct Moving {
    name: &'static str,
    file: &'static str,
    /// The momentum at the end.
    momentum: &'static str,
}

/// The constants of su(3) in the basis of Gell-Mann (1962, table II), with √3/2 among them.
const SU3: &str = r#"dimension = 8
constants = [
    [1, 2, 3, 1], [2, 3, 1, 1], [3, 1, 2, 1],
    [1, 4, 7, "1/2"], [4, 7, 1, "1/2"], [7, 1, 4, "1/2"],
    [1, 5, 6, "-1/2"], [5, 6, 1, "-1/2"], [6, 1, 5, "-1/2"],
    [2, 4, 6, "1/2"], [4, 6, 2, "1/2"], [6, 2, 4, "1/2"],
    [2, 5, 7, "1/2"], [5, 7, 2, "1/2"], [7, 2, 5, "1/2"],
    [3, 4, 5, "1/2"], [4, 5, 3, "1/2"], [5, 3, 4, "1/2"],
    [3, 6, 7, "-1/2"], [6, 7, 3, "-1/2"], [7, 3, 6, "-1/2"],
    [4, 5, 8, "sqrt(3)/2"], [5, 8, 4, "sqrt(3)/2"], [8, 4, 5, "sqrt(3)/2"],
    [6, 7, 8, "sqrt(3)/2"], [7, 8, 6, "sqrt(3)/2"], [8, 6, 7, "sqrt(3)/2"],
]
[lagrangian]
inertia = [1, 2, 3, "3/2", "1/2", "5/2", 2, 1]
[state]
momentum = ["1/2", "-1/3", "1/4", 1, "-1/2", "2/3", "1/5", "-3/4"]
"#;

/// Momenta by Taylor series of the equations of motion in 64 digits (70 terms; 8 steps and 12 agree to 1e-58), by another program.
const MOVING: [Moving; 4] = [
    Moving {
        name: "cubic drag on su(3)",
        file: "[[force]]\nkind = \"cubic-drag\"\nq = \"1/3\"\n",
        momentum: "0.302001994610176422820315393548240703 -0.271820977421465273620098702922763219 \
            0.156049118962522992562797555680651557 0.766867187464492667348517485551749738 \
            -0.235338506805267374059978442839633462 0.58384340398843235463197053314206784 \
            0.295191859577103747545546009951376373 -0.717646507543076802632155583112785186",
    },
    Moving {
        name: "a quartic beside a full inertia, on the algebra of the oscillator",
        file: r#"[algebra]
dimension = 4
constants = [[1, 2, 3, 1], [4, 1, 2, 1], [4, 2, 1, -1]]
[lagrangian]
inertia = [[2, "1/2", 0, "1/4"], ["1/2", "3/2", "-1/3", 0], [0, "-1/3", 1, "1/5"], ["1/4", 0, "1/5", "5/2"]]
quartic = "1/3"
metric = [1, "1/2", 0, "3/4"]
[state]
velocity = [1, "-1/2", "1/3", "3/2"]
"#,
        momentum: "2.43310256435726176764036905056379848 -2.18135598914698703777546158891564203 \
            0.8 4.53085911570224241335937937035571514",
    },
    Moving {
        name: "drag with a matrix that is not symmetric, on sl(2) beside the plane that it moves",
        file: r#"[algebra]
dimension = 5
constants = [[1, 2, 2, 2], [1, 3, 3, -2], [2, 3, 1, 1], [1, 4, 4, 1], [1, 5, 5, -1], [2, 5, 4, 1], [3, 4, 5, 1]]
[lagrangian]
inertia = [1, 2, "3/2", "1/2", 3]
[[force]]
kind = "linear-drag"
matrix = [
    ["1/2", "1/3", 0, 0, "-1/4"],
    ["-1/5", "1/4", 0, "1/7", 0],
    [0, "2/3", "1/3", 0, 0],
    ["-1/2", 0, "1/6", "2/5", 1],
    [0, 0, 0, "-1/3", "1/5"],
]
[state]
momentum = ["1/2", -1, "1/3", "3/4", "2/3"]
"#,
        momentum: "-0.362601988107035699023210410748149164 -1.1182426030874833129332995643280931 \
            0.0707600833881962351090663587970016405 0.443066337876728058504034390335778662 \
            0.6651360466120551253591492457243763",
    },
    Moving {
        name: "a double bracket on su(3)",
        file: "[[force]]\nkind = \"double-bracket\"\nalpha = \"1/5\"\n",
        momentum: "0.410153070106688651232544486844231209 -0.301578786044197209085042893397656545 \
            0.134636617012331127497152272595232325 0.913318994511828462838751962719372904 \
            -0.337487057892265636023489929871126898 0.669361880873266280094133899691032065 \
            0.388966762519811188393440465953724552 -0.946500745859707060176627688540861414",
    },
];

#[test]
fn files_on_structure_constants_have_the_reference_values_to_28_digits() {
    for Moving { name, file, momentum } in &MOVING {
        let algebra = if file.contains("[algebra]") { String::new() } else { format!("[algebra]\n{SU3}") };
        let text = format!(
            "format = 1\n{algebra}{file}[method]\ntableau = \"gauss-12\"\nretraction = \"exp\"\n\
             [run]\nstep = \"1/8\"\nsteps = 4\nscalar = \"dd\"\n"
        );
        let row = last::<Dd>(&text);
        for (k, known) in momentum.split(' ').enumerate() {
            let known: Dd = Number::parse(known).unwrap().eval().unwrap();
            let error = (row[1 + k] - known).to_f64().abs();
            assert!(error < 1e-28, "{name}: component {} is off by {error:e}", k + 1);
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
