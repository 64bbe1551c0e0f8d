#!/usr/bin/env python3
"""geomstats: the geodesic equation of a left-invariant metric on SO(3), one step of `geomstats.integrator`. Arguments: the step, and
the axes: `principal` or `body` (then the matrix of the metric is full)."""
import os
import sys

from body import Unsupported, hat, serve

os.environ.setdefault("GEOMSTATS_BACKEND", "numpy")
import numpy as np
from geomstats.geometry.invariant_metric import InvariantMetric
from geomstats.geometry.special_orthogonal import SpecialOrthogonal
from geomstats.integrator import integrate

STEP, AXES = sys.argv[1:]


def step(b):
    if b.se3 or not b.is_free:
        raise Unsupported("only free motion on SO(3)")
    group = SpecialOrthogonal(3, equip=False)  # its Lie algebra has the three cross-product matrices as its basis
    Q, d = b.principal() if AXES == "principal" else (np.eye(3), b.J)
    metric = InvariantMetric(group, np.diag(d) if d.ndim == 1 else d, left=True)
    state = np.stack([b.R @ Q, hat(Q.T @ b.w)])
    path = integrate(lambda state, _: metric.geodesic_equation(state), state, end_time=b.h, n_steps=1, step=STEP)
    R, omega = path[-1]
    return R @ Q.T, b.p, Q @ [omega[2, 1], omega[0, 2], omega[1, 0]], b.v


serve(step)
