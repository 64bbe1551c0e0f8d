//! Properties of `euler_poincare::laws`.
