#!/usr/bin/env python3
"""MuJoCo: a body with a free joint, mj_step. Argument: the integrator."""
import sys

from body import Unsupported, quaternion, rotation, serve

import mujoco
import numpy as np

MODELS = {}


def model_of(b):
    key = (b.mass, *b.center, *b.J.ravel())
    if key not in MODELS:
        Q, d = b.principal()
        spec = mujoco.MjSpec()
        body = spec.worldbody.add_body(mass=b.mass, ipos=b.center, inertia=d, iquat=quaternion(Q), explicitinertial=True)
        body.add_freejoint()
        MODELS[key] = spec.compile()
    return MODELS[key]


def step(b):
    model = model_of(b)
    model.opt.integrator = getattr(mujoco.mjtIntegrator, "mjINT_" + sys.argv[1].upper())
    model.opt.gravity, model.opt.timestep = 0, b.h
    data = mujoco.MjData(model)
    # The free joint: position and velocity in space, angular velocity and torque in the body frame.
    data.qpos = np.concatenate([b.p, quaternion(b.R)])
    data.qvel = np.concatenate([b.R @ b.v, b.w])
    data.qfrc_applied[3:] = b.torque
    if b.force.any():
        raise Unsupported("a force that turns with the body")
    mujoco.mj_step(model, data)
    R = rotation(data.qpos[3:])
    return R, data.qpos[:3], data.qvel[3:], R.T @ data.qvel[:3]


serve(step)
