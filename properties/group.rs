//! Properties of `euler_poincare::group`.
