//! Properties of `euler_poincare::scalar`.
