#!/usr/bin/env python3
"""Exudyn: a rigid body, one step of a dynamic solver. Arguments: the solver, and the node: EP (Euler parameters) or LG (Lie group)."""
import sys

from body import Unsupported, quaternion, serve

import exudyn
import numpy as np
from exudyn.itemInterface import NodeRigidBodyEP, NodeRigidBodyRotVecLG, ObjectRigidBody
from exudyn.rigidBodyUtilities import RotationMatrix2RotationVector

SOLVER, NODE = sys.argv[1:]


def step(b):
    if b.h < 0 or not b.is_free:
        raise Unsupported("a negative step" if b.h < 0 else "forces")
    system = exudyn.SystemContainer()
    mbs = system.AddSystem()
    velocity, R = b.R @ b.v, b.R
    if NODE == "EP":
        q = quaternion(R)
        w = b.w
        dq = np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)]) / 2
        node = NodeRigidBodyEP(referenceCoordinates=[*b.p, *q], initialVelocities=[*velocity, *dq])
    else:
        node = NodeRigidBodyRotVecLG(referenceCoordinates=[*b.p, *RotationMatrix2RotationVector(R)],
                                     initialVelocities=[*velocity, *b.w])
    node = mbs.AddNode(node)
    J = b.inertia[:3, :3]  # about the body's origin
    body = mbs.AddObject(ObjectRigidBody(
        nodeNumber=node, mass=b.mass, centerOfMass=list(b.center),
        inertia=[J[0, 0], J[1, 1], J[2, 2], J[1, 2], J[0, 2], J[0, 1]]))
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = 1
    settings.timeIntegration.endTime = b.h
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.timeIntegration.automaticStepSize = False
    settings.timeIntegration.newton.relativeTolerance = 1e-14
    settings.timeIntegration.newton.absoluteTolerance = 1e-14
    mbs.SolveDynamic(settings, solverType=getattr(exudyn.DynamicSolverType, SOLVER))

    def output(kind):
        return np.array(mbs.GetObjectOutputBody(body, getattr(exudyn.OutputVariableType, kind), [0, 0, 0]))
    R = output("RotationMatrix").reshape(3, 3)
    return R, output("Position"), output("AngularVelocityLocal"), R.T @ output("Velocity")


serve(step)
