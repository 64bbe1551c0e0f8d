//! Properties of `euler_poincare::tableau`.
