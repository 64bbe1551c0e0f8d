//! Properties of `euler_poincare::integrators`.
