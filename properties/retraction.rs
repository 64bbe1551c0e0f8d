//! Properties of `euler_poincare::retraction`.
