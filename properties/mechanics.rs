//! Properties of `euler_poincare::mechanics`.
