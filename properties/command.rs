//! Properties of `euler_poincare::command`.
