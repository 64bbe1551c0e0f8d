//! The library's methods as subjects of the laws of methods.

use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::{Classical, MuntheKaas, StepError, Variational};
use euler_poincare::laws::method::{MethodSource, Stepper, Untyped};
use euler_poincare::mechanics::equations::EulerPoincare;
use euler_poincare::system::{Case, System, Visitor};
use euler_poincare::tableau::Tableau;

/// How a method makes its step of a tableau.
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "a program may have methods of one kind alone")]
pub enum Engine {
    /// On (μ, g) as a vector.
    Classical,
    /// On the algebra, by the retraction of the case.
    MuntheKaas,
    /// The variational integrator of the pair (a, â).
    Variational,
    /// The same with its stages found to this relative tolerance.
    Loose(f64),
}

pub struct Method(pub Engine, pub Tableau<f64>);

/// Builds a stepper on a system.
struct Build<'m>(&'m Method);

impl Visitor<f64> for Build<'_> {
    type Output = Box<dyn Stepper<f64>>;

    const LARGE: bool = false;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Self::Output {
        let System { algebra, group, lagrangian, force, retraction, .. } = system;
        let Method(engine, tableau) = self.0;
        let (tableau, mut settings) = (tableau.clone(), Settings::default());
        if let Engine::Variational | Engine::Loose(_) = engine {
            if let Engine::Loose(tolerance) = engine {
                settings.tolerance = *tolerance;
            }
            let method = Variational::with_settings(lagrangian, force, retraction, tableau, settings);
            return Box::new(Untyped::<_, N, D>(method));
        }
        let body = EulerPoincare::new(algebra, lagrangian, force);
        match engine {
            Engine::MuntheKaas => Box::new(Untyped::<_, N, D>(MuntheKaas::new(body, retraction, tableau))),
            _ => Box::new(Untyped::<_, N, D>(Classical::new(body, group, tableau))),
        }
    }
}

impl MethodSource for Method {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        let built = case.dispatch::<f64, _>(Build(self));
        built.map(|stepper| stepper as _).map_err(|error| StepError::Unsupported { why: error.to_string() })
    }
}
