//! The macros that make tests of a user's own types.

/// A `#[test]` for each law of a user's own types, in a module of that name.
///
/// `mod NAME<T, N, D> { group: VALUE, … }`: T names the scalar in the values, which have to work for every
/// [`Real`](crate::scalar::Real); N is the dimension of the group and D the size of its matrices. Every key but the first may
/// be left out; what is not given is the library's, or drawn:
///
/// | key | value | without it |
/// |---|---|---|
/// | `group` | a [`LieGroup`](crate::group::LieGroup) | |
/// | `retraction` | a [`Retraction`](crate::retraction::Retraction) | exp of the group |
/// | `map` | τ alone, a [`Map`](crate::laws::user::Map); instead of `retraction` | |
/// | `lagrangian` | a [`Lagrangian`](crate::mechanics::Lagrangian) | random inertias |
/// | `force` | a [`Force`](crate::mechanics::Force) | random forces |
/// | `casimirs` | a `Vec` of [`Casimir`](crate::algebra::Casimir)s | none are known |
/// | `method` | a closure from the [`System`](crate::system::System) to a [`OneStep`](crate::integrators::OneStep) | |
/// | `claims` | the [`Claims`](crate::laws::method::Claims) that the method makes | none |
///
/// A test of a law that needs a key is ignored without it, and says what it needs. Single parts: `mod NAME<T, N> { algebra:
/// VALUE }`, `{ lagrangian: VALUE }` and `{ force: VALUE }`; `mod NAME<T> { groupoid: VALUE }` and `{ lie_groupoid: VALUE
/// }`; `mod NAME<T, N, D> { discrete: VALUE }`, see [`laws::user`](mod@crate::laws::user). How tests run:
/// [`crate::laws::user::suite`].
///
/// ```
/// use euler_poincare::group::So3;
/// use euler_poincare::laws;
///
/// laws! {
///     mod rotations<T, 3, 3> { group: So3::<T>::new() }
/// }
/// # fn main() {}
/// ```
#[macro_export]
macro_rules! laws {
    ($($suite:tt)*) => { $crate::__own! { tests; $($suite)* } };
}

/// The same as [`laws!`](crate::laws!) without the tests: a module with `suite()`, to run laws in one's own way.
#[macro_export]
macro_rules! suite {
    ($($suite:tt)*) => { $crate::__own! { none; $($suite)* } };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __own {
    ($tests:ident; $vis:vis mod $name:ident<$t:ident, $n:literal, $d:literal> { group: $($rest:tt)* }) => {
        $crate::__own_system! { $tests; $vis $name $t $n $d { group: $($rest)* } }
    };
    (
        $tests:ident; $vis:vis mod $name:ident<$t:ident $(, $number:literal)*> {
            $key:ident: $value:expr $(, claims: [$($claim:ident),* $(,)?])? $(,)?
        }
    ) => {
        $crate::__own_part! { $key [$t $(, $number)*] { $tests; $vis $name; $value; $($($claim)*)? } }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __own_system {
    (
        $tests:ident; $vis:vis $name:ident $t:ident $n:literal $d:literal
        { group: $group:expr $(, $key:ident: $value:expr)* $(,)? }
    ) => {
        $vis mod $name {
            #[allow(unused_imports)]
            use super::*;

            fn user_types<$t: $crate::scalar::Real>() -> $crate::laws::user::Own<$t, $n, $d> {
                let own = $crate::laws::user::Own::new($group);
                $(let own = $crate::__own_key! { own $key $value; $group };)*
                own
            }

            /// The laws on these types.
            pub fn suite() -> $crate::laws::user::Suite {
                let site = $crate::laws::user::Site {
                    module: module_path!(),
                    manifest: env!("CARGO_MANIFEST_DIR"),
                };
                $crate::laws::user::Suite::of(site, user_types, user_types)
            }

            #[allow(dead_code, non_upper_case_globals)]
            mod each_key_once {
                $($crate::__own_once! { $key })*
            }

            $crate::__own_lists! { $tests [$($key)*] }
        }
    };
}

/// A name for each key: the compiler refuses a key that is given twice, and τ in two ways.
#[doc(hidden)]
#[macro_export]
macro_rules! __own_once {
    (map) => {
        const retraction: () = ();
    };
    ($key:ident) => {
        const $key: () = ();
    };
}

/// The types with what a key adds.
#[doc(hidden)]
#[macro_export]
macro_rules! __own_key {
    ($own:ident map $value:expr; $group:expr) => {
        $own.retraction(|| $crate::laws::user::FromMap::new($value, $group))
    };
    ($own:ident method $value:expr; $group:expr) => {
        $own.method(|system| $crate::laws::user::system::method_on(system, $value))
    };
    ($own:ident retraction $value:expr; $group:expr) => {
        $own.retraction(|| $value)
    };
    ($own:ident lagrangian $value:expr; $group:expr) => {
        $own.lagrangian(|| $value)
    };
    ($own:ident force $value:expr; $group:expr) => {
        $own.force(|| $value)
    };
    ($own:ident casimirs $value:expr; $group:expr) => {
        $own.casimirs(|| $value)
    };
    ($own:ident claims $value:expr; $group:expr) => {
        $own.claims(|| $value)
    };
    ($own:ident $key:ident $($rest:tt)*) => {
        compile_error!(concat!(
            "there is no key `",
            stringify!($key),
            "`; the keys are group, retraction, map, lagrangian, force, casimirs, method, claims"
        ))
    };
}

/// The tests of laws on systems, by the key that they need. Those on parts stand beside the laws.
#[doc(hidden)]
#[macro_export]
macro_rules! __own_lists {
    (none [$($key:ident)*]) => {};
    (tests [$($key:ident)*]) => {
        $crate::__own_group! { {} every }
        $crate::__own_algebra! { {} every }
        $crate::__own_tests! { {}
            retraction_inverse
            retraction_accuracy step_accuracy
            plain_step discrete_noether free_coadjoint_orbit free_poisson_map
            doubled_restriction doubled_splitting doubled_momentum_map
            lie_poisson_equations energy_rate dalembert_principle
            coupling_antisymmetry doubled_antisymmetry doubled_partials
            first_variation units_carry_forced_euler_poincare stationary_action
            legendre_round_trip legendre_intertwines legendre_hamiltonian
            hamilton_equations hamiltonian_conserved forced_hamiltonian_partials free_hamiltonian_units
            forced_hamiltonian_units hamiltonian_regularity
            two_hamiltonians_units two_hamiltonians_load two_hamiltonians
            discrete_slopes doubled_step_generated discrete_antisymmetry discrete_flow discrete_restricted_step
            exact_antisymmetry exact_generates_flow exact_free munthe_kaas_step
            order_momentum_attitude energy_balance order_predicted order_munthe_kaas
            branch solve_dense configuration_gradient configuration_space_form
        }
        $crate::__own_needs! { map [$($key)*]
            { ignore = "needs `retraction`: with `map` it would compare a thing with itself" } {} __own_tests
            retraction_logarithm retraction_tangent retraction_inverse_tangent retraction_second_tangent
            retraction_adjoint
        }
        $crate::__own_needs! { casimirs [$($key)*] {} { ignore = "needs `casimirs`" } __own_tests free_casimirs }
        $crate::__own_needs! { casimirs [$($key)*] {} { ignore = "needs `casimirs`" } __own_algebra claimed }
        $crate::__own_needs! { lagrangian [$($key)*] {} { ignore = "needs `lagrangian`" } __own_lagrangian every }
        $crate::__own_needs! { method [$($key)*] {} { ignore = "needs `method`" } __own_tests
            method_order method_casimirs method_energy method_reversibility method_momentum
            method_equivariance method_smoothness
        }
        $crate::__own_needs! { claims [$($key)*] {} { ignore = "needs `method` and `claims`" } __own_tests
            method_conserves_casimirs method_conserves_energy method_conserves_momentum
            method_noether method_poisson method_variational
        }
        $crate::__own_needs! { force [$($key)*] {} { ignore = "needs `force`" } __own_force every }
    };
}

/// Tests, as a macro makes them, with the first attribute if the key is in the list, else with the second.
#[doc(hidden)]
#[macro_export]
macro_rules! __own_needs {
    (map [map $($rest:ident)*] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $yes $($test)* } };
    (casimirs [casimirs $($rest:ident)*] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $yes $($test)* } };
    (lagrangian [lagrangian $($rest:ident)*] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $yes $($test)* } };
    (force [force $($rest:ident)*] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $yes $($test)* } };
    (method [method $($rest:ident)*] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $yes $($test)* } };
    (claims [claims $($rest:ident)*] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $yes $($test)* } };
    ($key:ident [$other:ident $($rest:ident)*] $($tests:tt)*) => {
        $crate::__own_needs! { $key [$($rest)*] $($tests)* }
    };
    ($key:ident [] $yes:tt $no:tt $make:ident $($test:ident)*) => { $crate::$make! { $no $($test)* } };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __own_tests {
    ($attributes:tt $($name:ident)*) => { $($crate::__own_test! { $attributes $name })* };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __own_test {
    ({ $($attribute:meta)? } $name:ident) => {
        #[test]
        $(#[$attribute])?
        fn $name() {
            suite().test(stringify!($name));
        }
    };
}

/// A suite on a single part.
#[doc(hidden)]
#[macro_export]
macro_rules! __own_part {
    (algebra [$t:ident, $n:literal] $suite:tt) => {
        $crate::__own_single! { $suite $t { $crate::laws::user::algebra::Bracket<$t, $n> } { $crate::laws::user::algebra::UserAlgebra } __own_algebra }
    };
    (lagrangian [$t:ident, $n:literal] $suite:tt) => {
        $crate::__own_single! { $suite $t { $crate::mechanics::Lagrangian<$t, $n> } { $crate::laws::user::lagrangian::UserLagrangian } __own_lagrangian }
    };
    (force [$t:ident, $n:literal] $suite:tt) => {
        $crate::__own_single! { $suite $t { $crate::mechanics::Force<$t, $n> } { $crate::laws::user::force::UserForce } __own_force }
    };
    (groupoid [$t:ident] $suite:tt) => {
        $crate::__own_single! { $suite $t { $crate::laws::user::groupoid::Chains<Real = $t> } { $crate::laws::user::groupoid::UserGroupoid } __own_groupoid }
    };
    (lie_groupoid [$t:ident] $suite:tt) => {
        $crate::__own_single! { $suite $t { $crate::laws::user::groupoid::LieChains<$t> } { $crate::laws::user::groupoid::UserLieGroupoid } __own_lie_groupoid }
    };
    (discrete [$t:ident, $n:literal, $d:literal] $suite:tt) => {
        $crate::__own_single! {
            $suite $t { $crate::laws::user::part::Answers<$t, $crate::laws::user::discrete::DiscreteLaws<$n, $d>> }
            { $crate::laws::user::discrete::UserDiscrete } __own_discrete
        }
    };
    ($key:ident $parameters:tt $suite:tt) => {
        compile_error!(concat!(
            "no suite for the key `", stringify!($key), "` with the parameters ", stringify!($parameters),
            "; there are <T, N, D> { group: … }, <T, N> { algebra | lagrangian | force: … }, ",
            "<T> { groupoid | lie_groupoid: … }, <T, N, D> { discrete: … }"
        ));
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __own_single {
    (
        { $tests:ident; $vis:vis $name:ident; $value:expr; $($claim:ident)* }
        $t:ident { $($bound:tt)* } { $($subject:tt)* } $list:ident
    ) => {
        $vis mod $name {
            #[allow(unused_imports)]
            use super::*;

            #[allow(clippy::implied_bounds_in_impls, reason = "some of the traits have these bounds")]
            fn part<$t: $crate::scalar::Real>() -> impl $($bound)* + Send + Sync + 'static {
                $value
            }

            /// The laws on this part.
            pub fn suite() -> $crate::laws::user::Suite {
                let site = $crate::laws::user::Site {
                    module: module_path!(),
                    manifest: env!("CARGO_MANIFEST_DIR"),
                };
                let part = $($subject)*::at_both(part::<f64>(), part::<$crate::scalar::Dd>())$(.$claim())*;
                $crate::laws::user::Suite::new(site).part(part)
            }

            $crate::__own_single_tests! { $tests $list }
        }
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __own_single_tests {
    (none $list:ident) => {};
    (tests $list:ident) => {
        $crate::$list! { {} every }
        $crate::$list! { {} claimed }
    };
}
