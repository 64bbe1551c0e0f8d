#!/usr/bin/env python3
"""Drake: a MultibodyPlant with a quaternion floating body. Argument: an integrator, in one fixed step; `discrete`: a plant in time steps."""
import sys

from body import Unsupported, quaternion, rotation, serve

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RotationalInertia, SpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

SCHEME = sys.argv[1]


def step(b):
    if b.h < 0 or not b.is_free:
        raise Unsupported("a negative step" if b.h < 0 else "forces")
    plant = MultibodyPlant(b.h if SCHEME == "discrete" else 0.0)
    J = RotationalInertia(*np.diag(b.J), b.J[0, 1], b.J[0, 2], b.J[1, 2])
    plant.AddRigidBody("body", SpatialInertia.MakeFromCentralInertia(b.mass, b.center, J))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    # A floating body: quaternion (w, x, y, z) and position; angular and linear velocity, both in space.
    plant.SetPositions(context, np.concatenate([quaternion(b.R), b.p]))
    plant.SetVelocities(context, np.concatenate([b.R @ b.w, b.R @ b.v]))
    if SCHEME != "discrete":
        ResetIntegratorFromFlags(simulator, SCHEME, b.h).set_fixed_step_mode(True)
    simulator.AdvanceTo(b.h)
    q, v = plant.GetPositions(context), plant.GetVelocities(context)
    R = rotation(q[:4])
    return R, q[4:], R.T @ v[:3], R.T @ v[3:]


serve(step)
