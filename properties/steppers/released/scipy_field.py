#!/usr/bin/env python3
"""SciPy: one step of a method of `scipy.integrate`, tolerances so large that it is accepted.

Arguments: RK23, RK45, DOP853 or Radau, and how the attitude is stored: `matrix` or `quaternion`. Radau takes the tolerance of its
Newton iteration from that of the error. Here it is 1e-14, and the iteration may take longer than the six rounds of the package.
"""
import sys

from body import serve

import numpy as np
import scipy.integrate

import field

METHOD, KIND = sys.argv[1:]
TOLERANCE = 1e6
if METHOD == "Radau":
    scipy.integrate._ivp.radau.NEWTON_MAXITER = 60


def step(b):
    solver = getattr(scipy.integrate, METHOD)(
        lambda t, y: field.rate(np, KIND, b.inertia, b.torque, b.force, y), b.time, field.start(b, KIND), b.time + b.h,
        first_step=abs(b.h), rtol=TOLERANCE, atol=TOLERANCE)
    if METHOD == "Radau":
        solver.newton_tol = 1e-14 / TOLERANCE
    solver.step()
    assert solver.t == b.time + b.h, "one step"
    return field.state(b, KIND, solver.y)


serve(step)
