#!/usr/bin/env python3
"""MJX (MuJoCo in JAX), in 64 bits: a body with a free joint, mjx.step. Argument: the integrator."""
import sys

from body import Unsupported, quaternion, rotation, serve

import jax
import mujoco
import numpy as np
from mujoco import mjx

jax.config.update("jax_enable_x64", True)
MODELS, STEP = {}, jax.jit(mjx.step)


def model_of(b):
    key = (b.mass, *b.center, *b.J.ravel())
    if key not in MODELS:
        Q, d = b.principal()
        spec = mujoco.MjSpec()
        body = spec.worldbody.add_body(mass=b.mass, ipos=b.center, inertia=d, iquat=quaternion(Q), explicitinertial=True)
        body.add_freejoint()
        model = spec.compile()
        model.opt.integrator = getattr(mujoco.mjtIntegrator, "mjINT_" + sys.argv[1].upper())
        model.opt.gravity = 0
        MODELS[key] = mjx.put_model(model), mjx.make_data(model)
    return MODELS[key]


def step(b):
    if not b.is_free:
        raise Unsupported("forces")
    model, data = model_of(b)
    model = model.tree_replace({"opt.timestep": np.float64(b.h)})
    data = data.replace(qpos=np.concatenate([b.p, quaternion(b.R)]), qvel=np.concatenate([b.R @ b.v, b.w]))
    data = STEP(model, data)
    R, v = rotation(data.qpos[3:]), np.array(data.qvel)
    return R, np.array(data.qpos[:3]), v[3:], R.T @ v[:3]


serve(step)
