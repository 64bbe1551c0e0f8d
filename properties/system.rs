//! Properties of `euler_poincare::system`.
