//! The two closed forms of SO(3), chosen at run time, on SO(3)×ℝᴺ⁻³.

use super::so3::{CayleySo3, CayleySo3Point, ExponentialSo3, ExponentialSo3Point};
use super::{Retraction, RetractionError, TangentPoint};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::matrix::Beside;
use crate::group::{LieGroup, So3};
use crate::scalar::{Real, Scalar};

/// A closed form of SO(3).
#[derive(Clone, Debug)]
#[doc(hidden)]
pub enum Form<T: Real> {
    /// The Cayley map.
    Cayley(CayleySo3<T>),
    /// The exponential.
    Exponential(ExponentialSo3<T>),
}

/// Cayley or exp on SO(3) in the standard basis, beside N − 3 spectators, on which it is x ↦ 1 + x̂.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct So3Retraction<T: Real, const N: usize = 3, const D: usize = 3> {
    form: Form<T>,
    algebra: LieAlgebra<T, N>,
    beside: Beside,
}

impl<T: Real> So3Retraction<T> {
    /// The closed form on SO(3) itself.
    pub fn new(form: impl Into<Form<T>>) -> Self {
        Self { form: form.into(), algebra: So3::new().algebra().clone(), beside: Beside::alone(3, 3) }
    }
}

impl<T: Real, const N: usize, const D: usize> So3Retraction<T, N, D> {
    /// The closed form beside spectators; `algebra` is so(3)⊕ℝᴺ⁻³. `None` where N or D is too small.
    pub(crate) fn beside(form: Form<T>, algebra: LieAlgebra<T, N>) -> Option<Self> {
        let beside = Beside::new(3, 3, N).filter(|beside| beside.rows() <= D)?;
        Some(Self { form, algebra, beside })
    }

    /// Which of the two.
    pub(crate) fn form(&self) -> &Form<T> {
        &self.form
    }
}

/// The same expression for either form.
macro_rules! in_form {
    ($value:expr, $of:ident, $inner:ident => $body:expr) => {
        match $value {
            $of::Cayley($inner) => $body,
            $of::Exponential($inner) => $body,
        }
    };
}

fn leading<S: Scalar>(x: &[S]) -> Vector<S, 3> {
    Vector::<S, 3>::new(x[0], x[1], x[2])
}

/// The matrix with this block before `one` on the diagonal.
fn beside_one<S: Scalar, const N: usize>(block: &Matrix<S, 3>, one: S) -> Matrix<S, N> {
    let mut matrix = Matrix::<S, N>::from_diagonal_element(one);
    for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
        matrix[(r, c)] = block[(r, c)];
    }
    matrix
}

impl<T: Real, const N: usize, const D: usize> Retraction<T, N, D> for So3Retraction<T, N, D> {
    type Point<S: Scalar<Base = T>> = So3Point<S, N>;

    fn name(&self) -> &'static str {
        in_form!(&self.form, Form, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let mut g = beside_one(&in_form!(&self.form, Form, r => r.tau(&leading(x.as_slice())))?, S::one());
        (3..N).for_each(|a| g[self.beside.entry(a - 3)] = x[a]);
        Ok(g)
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let block = Matrix::<S, 3>::from_fn(|r, c| g[(r, c)]);
        let x = in_form!(&self.form, Form, r => r.tau_inv(&block))?;
        Ok(Vector::from_fn(|a, _| if a < 3 { x[a] } else { g[self.beside.entry(a - 3)] }))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<So3Point<S, N>, RetractionError> {
        let x = leading(x.as_slice());
        let form = match &self.form {
            Form::Cayley(r) => FormPoint::Cayley(r.at(&x)?),
            Form::Exponential(r) => FormPoint::Exponential(r.at(&x)?),
        };
        let (d, d_inv) = in_form!(&form, FormPoint, p => (*p.d(), *p.d_inv()));
        Ok(So3Point { form, d: beside_one(&d, S::one()), d_inv: beside_one(&d_inv, S::one()) })
    }

    fn rough_pays_from(&self) -> usize {
        in_form!(&self.form, Form, r => r.rough_pays_from())
    }

    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        let [first, speed] = [x, eta].map(|v| [v[0], v[1], v[2]]);
        let turned = in_form!(&self.form, Form, r => r.rough_rates(brackets, &first, &speed));
        std::array::from_fn(|a| if a < 3 { turned[a] } else { eta[a] })
    }
}

#[derive(Clone, Debug)]
enum FormPoint<S: Scalar> {
    Cayley(CayleySo3Point<S>),
    Exponential(ExponentialSo3Point<S>),
}

/// The tangents of [`So3Retraction`] at a point.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct So3Point<S: Scalar, const N: usize> {
    form: FormPoint<S>,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
}

impl<S: Scalar, const N: usize> TangentPoint<S, N> for So3Point<S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        beside_one(&in_form!(&self.form, FormPoint, p => p.d_neg()), S::one())
    }

    fn ad(&self) -> Matrix<S, N> {
        beside_one(&in_form!(&self.form, FormPoint, p => p.ad()), S::one())
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        beside_one(&in_form!(&self.form, FormPoint, p => p.ad_inv()), S::one())
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        beside_one(&in_form!(&self.form, FormPoint, p => p.dd(&leading(y.as_slice()))), S::zero())
    }

    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let [p, m, y] = [p.as_slice(), m.as_slice(), y.as_slice()].map(leading);
        let pulled = in_form!(&self.form, FormPoint, point => point.pull_dd(&p.transpose(), &m.transpose(), &y));
        Covector::from_fn(|_, a| if a < 3 { pulled[a] } else { S::zero() })
    }
}
