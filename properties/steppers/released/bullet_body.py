#!/usr/bin/env python3
"""Bullet by pybullet, in double precision: a body as createMultiBody makes it (a btMultiBody), stepSimulation."""
from body import quaternion, rotation, serve

import numpy as np
import pybullet as bullet

bullet.connect(bullet.DIRECT)


def step(b):
    Q, d = b.principal()  # Bullet has diagonal inertias only, about the center
    bullet.resetSimulation()
    bullet.setGravity(0, 0, 0)
    body = bullet.createMultiBody(b.mass)
    bullet.changeDynamics(body, -1, localInertiaDiagonal=list(d), linearDamping=0, angularDamping=0, jointDamping=0,
                          maxJointVelocity=1e9, activationState=bullet.ACTIVATION_STATE_DISABLE_SLEEPING)
    bullet.setTimeStep(b.h)
    x, u = b.at_center()
    bullet.resetBasePositionAndOrientation(body, list(x), list(np.roll(quaternion(b.R @ Q), -1)))
    bullet.resetBaseVelocity(body, list(u), list(b.R @ b.w))  # both in space
    if not b.is_free:
        bullet.applyExternalForce(body, -1, list(b.R @ b.force), list(x), bullet.WORLD_FRAME)
        bullet.applyExternalTorque(body, -1, list(b.R @ (b.torque - np.cross(b.center, b.force))), bullet.WORLD_FRAME)
    bullet.stepSimulation()
    x, q = bullet.getBasePositionAndOrientation(body)
    u, w = bullet.getBaseVelocity(body)
    R = rotation(np.roll(q, 1)) @ Q.T
    return b.from_center(R, np.array(x), R.T @ w, np.array(u))


serve(step)
