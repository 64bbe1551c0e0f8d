//! Properties of `euler_poincare::groupoid`.
