//! Tableaux with a fault planted in them.

use crate::harness::Fault;
use crate::scalar::Real;
use crate::tableau::Tableau;

pub const COEFFICIENT: Fault =
    Fault::new("coefficient-off", "the coefficient a_s1 off by 1e-6", "forced systems, or non-abelian algebras");
pub const WRONG_STAGE: Fault = Fault::new(
    "wrong-stage",
    "a stage i ≥ 3 takes the slope of stage 1 where that of stage i − 1 belongs",
    "s ≥ 3, a_{i,i−1} ≠ 0; motions that are not steady",
);

/// The tableau with the fault planted in it, if it is one of these.
pub fn planted<T: Real>(tableau: &Tableau<T>, fault: Option<&Fault>) -> Tableau<T> {
    let s = tableau.stages();
    let mut rows: Vec<Vec<T>> = (0..s).map(|i| (0..s).map(|j| tableau.a()[(i, j)]).collect()).collect();
    match fault {
        Some(fault) if fault.name == COEFFICIENT.name => {
            rows[s - 1][0] += T::ratio(1, 1_000_000) * T::exact(fault.size);
        }
        Some(fault) if fault.name == WRONG_STAGE.name => {
            for i in 2..s {
                let moved = rows[i][i - 1] * T::exact(fault.size);
                rows[i][0] += moved;
                rows[i][i - 1] -= moved;
            }
        }
        _ => return tableau.clone(),
    }
    // The weights are those of a tableau: nothing of them changed.
    let b: Vec<T> = tableau.b().iter().copied().collect();
    Tableau::new(&rows, &b).unwrap_or_else(|_| tableau.clone())
}
