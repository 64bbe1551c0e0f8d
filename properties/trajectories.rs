//! Properties of `euler_poincare::trajectories`.
