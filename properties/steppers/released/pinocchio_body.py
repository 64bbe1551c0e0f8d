#!/usr/bin/env python3
"""Pinocchio: a free-flyer, `aba` and `integrate`. Argument: `semi-implicit` (the loop of its examples) or `explicit`."""
import sys

from body import quaternion, rotation, serve

import numpy as np
import pinocchio as pin


def step(b):
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    model.appendBodyToJoint(joint, pin.Inertia(b.mass, b.center, b.J), pin.SE3.Identity())
    model.gravity.linear = np.zeros(3)
    # The free-flyer: position and quaternion (x, y, z, w); velocity and force in the body frame, linear parts first.
    q = np.concatenate([b.p, np.roll(quaternion(b.R), -1)])
    v = np.concatenate([b.v, b.w])
    after = v + b.h * pin.aba(model, model.createData(), q, v, np.concatenate([b.force, b.torque]))
    q = pin.integrate(model, q, b.h * (after if sys.argv[1] == "semi-implicit" else v))
    return rotation(np.roll(q[3:], 1)), q[:3], after[3:], after[:3]


serve(step)
