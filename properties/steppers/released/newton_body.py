#!/usr/bin/env python3
"""Newton on the processor, in 32 bits: a free body, the semi-implicit solver. Argument: a solver."""
import sys

from body import Unsupported, quaternion, rotation, serve

import newton
import numpy as np
import warp as wp

OPTIONS = {"SolverSemiImplicit": {"angular_damping": 0.0}}
MODELS = {}


def model_of(b):
    key = (b.mass, *b.center, *b.J.ravel())
    if key not in MODELS:
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
        builder.add_body(com=wp.vec3(b.center), inertia=wp.mat33(b.J.ravel()), mass=b.mass, lock_inertia=True)
        model = builder.finalize(device="cpu")
        solver = getattr(newton.solvers, sys.argv[1])(model, **OPTIONS.get(sys.argv[1], {}))
        MODELS[key] = solver, model.state(), model.state(), model.control()
    return MODELS[key]


def step(b):
    if not b.is_free:
        raise Unsupported("forces")
    solver, before, after, control = model_of(b)
    x, u = b.at_center()
    before.body_q.assign(np.array([[*b.p, *np.roll(quaternion(b.R), -1)]], np.float32))
    # Velocity of the center of mass and angular velocity, both in space.
    before.body_qd.assign(np.array([[*u, *(b.R @ b.w)]], np.float32))
    before.clear_forces()
    solver.step(before, after, control, None, b.h)
    q, v = after.body_q.numpy()[0].astype(float), after.body_qd.numpy()[0].astype(float)
    R = rotation(np.roll(q[3:], 1))
    return b.from_center(R, q[:3] + R @ b.center, R.T @ v[3:], v[:3])


serve(step)
