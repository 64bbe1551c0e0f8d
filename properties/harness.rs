//! Properties of `euler_poincare::harness`.
