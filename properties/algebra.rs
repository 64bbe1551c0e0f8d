//! Properties of `euler_poincare::algebra`.
