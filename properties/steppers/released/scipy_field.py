#!/usr/bin/env python3
"""SciPy: one step of an explicit method of `scipy.integrate`, tolerances so large that it is accepted.

Arguments: RK23, RK45 or DOP853, and how the attitude is stored: `matrix` or `quaternion`.
"""
import sys

from body import serve

import numpy as np
import scipy.integrate

import field

METHOD, KIND = sys.argv[1:]


def step(b):
    solver = getattr(scipy.integrate, METHOD)(
        lambda t, y: field.rate(np, KIND, b.inertia, b.torque, b.force, y), b.time, field.start(b, KIND), b.time + b.h,
        first_step=abs(b.h), rtol=1e6, atol=1e6)
    solver.step()
    assert solver.t == b.time + b.h, "one step"
    return field.state(b, KIND, solver.y)


serve(step)
