//! Laws of the fast steps ([`crate::integrators::lanes`], [`crate::integrators::so3`]), which are judged as
//! they run: in 16 digits, in every kind of registers that the processor has.
//!
//! A step is compared with the general engine in 32 digits, many bodies with each of them, a solver with the solution; the laws
//! of methods have the fast step as their subject (`Fast`).

mod condition;
mod engine;
mod ensemble;
mod method;
mod noether;
mod solver;
mod step;

use crate::laws::CaseLaw;
use crate::tableau::{Description, Family, random};
use proptest::sample::select;
use proptest::strategy::{BoxedStrategy, Strategy, Union};

/// The most stages that fit into the lanes.
const MOST: usize = 8;

/// Any tableau (they have five stages at most), and those of the families up to eight.
fn tableaux() -> BoxedStrategy<Description> {
    let of = |family: Family| (family.least_stages()..=MOST).map(move |stages| Description::Family(family, stages));
    // Gauss is what the solvers are made of.
    let gauss: Vec<_> = of(Family::Gauss).collect();
    let all: Vec<_> = Family::ALL.into_iter().flat_map(of).collect();
    Union::new([random::any(), select(gauss).boxed(), select(all).boxed()]).boxed()
}

/// The laws of this folder.
pub fn laws() -> Vec<&'static CaseLaw> {
    [step::LAWS, noether::LAWS, ensemble::LAWS, solver::LAWS, method::LAWS].into_iter().flatten().collect()
}
