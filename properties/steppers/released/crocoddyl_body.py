#!/usr/bin/env python3
"""Crocoddyl: the integrated action models on a free-flyer. Argument: euler, rk2, rk3 or rk4."""
import sys

from body import Unsupported, quaternion, rotation, serve

import crocoddyl
import numpy as np
import pinocchio as pin


def step(b):
    if not b.is_free:
        raise Unsupported("a force on the base")
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    model.appendBodyToJoint(joint, pin.Inertia(b.mass, b.center, b.J), pin.SE3.Identity())
    model.gravity.linear = np.zeros(3)
    state = crocoddyl.StateMultibody(model)
    actuation = crocoddyl.ActuationModelFloatingBase(state)
    costs = crocoddyl.CostModelSum(state, actuation.nu)
    motion = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs)
    if sys.argv[1] == "euler":
        action = crocoddyl.IntegratedActionModelEuler(motion, b.h)
    else:
        action = crocoddyl.IntegratedActionModelRK(motion, getattr(crocoddyl.RKType, {"rk2": "two", "rk3": "three", "rk4": "four"}[sys.argv[1]]), b.h)
    x = np.concatenate([b.p, np.roll(quaternion(b.R), -1), b.v, b.w])
    data = action.createData()
    action.calc(data, x, np.zeros(actuation.nu))
    x = data.xnext
    return rotation(np.roll(x[3:7], 1)), x[:3], x[10:], x[7:10]


serve(step)
