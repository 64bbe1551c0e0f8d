"""The equations of a rigid body as a vector field for general solvers: y = (momentum, position, attitude).

The attitude is a `matrix` by rows or a `quaternion` (w, x, y, z), which may leave the unit sphere. `xp` is numpy or jax.numpy.
"""
import numpy as np

from body import quaternion, rotation


def rate(xp, kind, inertia, torque, force, y):
    n = len(inertia)
    mu, (p, turn) = y[:n], (y[n:n + 3], y[n + 3:])
    eta = xp.linalg.solve(inertia, mu)
    w = eta[:3]
    if kind == "matrix":
        R = turn.reshape(3, 3)
        dR = xp.stack([xp.cross(row, w) for row in R]).ravel()
    else:
        s, u = turn[0], turn[1:]
        dR = xp.concatenate([-xp.dot(u, w)[None], s * w + xp.cross(u, w)]) / 2
        length = s * s + xp.dot(u, u)
        R = None
    dmu = xp.cross(mu[:3], w) + torque
    if n == 3:
        return xp.concatenate([dmu, xp.zeros(3), dR])
    v = eta[3:]
    if kind == "quaternion":  # the rotation of the normalised quaternion
        dp = v + 2 * xp.cross(u, s * v + xp.cross(u, v)) / length
    else:
        dp = R @ v
    return xp.concatenate([dmu + xp.cross(mu[3:], v), xp.cross(mu[3:], w) + force, dp, dR])


def start(b, kind):
    eta = np.concatenate([b.w, b.v])[:len(b.inertia)]
    return np.concatenate([b.inertia @ eta, b.p, b.R.ravel() if kind == "matrix" else quaternion(b.R)])


def state(b, kind, y):
    n, y = len(b.inertia), np.array(y)
    eta = np.linalg.solve(b.inertia, y[:n])
    R = y[n + 3:].reshape(3, 3) if kind == "matrix" else rotation(y[n + 3:])
    return R, y[n:n + 3], eta[:3], eta[3:] if b.se3 else np.zeros(3)
