#!/usr/bin/env python3
"""Basilisk: a spacecraft's hub (modified Rodrigues parameters), one step of a state vector integrator. Argument: its name."""
import sys

from body import Unsupported, quaternion, rotation, serve

import numpy as np
from Basilisk.simulation import spacecraft, svIntegrators
from Basilisk.utilities import SimulationBaseClass


def column(x):
    return [[float(value)] for value in x]


def step(b):
    if not b.is_free:
        raise Unsupported("forces")
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", 10**9))
    craft = spacecraft.Spacecraft()
    craft.hub.mHub, craft.hub.IHubPntBc_B = float(b.mass), b.J.tolist()  # the hub's origin is its center of mass
    craft.hub.r_BcB_B = column([0, 0, 0])
    integrator = getattr(svIntegrators, sys.argv[1])(craft)
    craft.setIntegrator(integrator)
    q, (x, u) = quaternion(b.R), b.at_center()
    q = q if q[0] >= 0 else -q
    craft.hub.sigma_BNInit, craft.hub.omega_BN_BInit = column(q[1:] / (1 + q[0])), column(b.w)
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = column(x), column(u)
    simulation.AddModelToTask("task", craft)
    simulation.InitializeSimulation()
    integrator.integrate(0.0, b.h)  # not ExecuteSimulation: its steps are whole nanoseconds

    def state(name):
        return np.ravel(craft.dynManager.getStateObject(name).getState())
    hub = craft.hub
    sigma = state(hub.nameOfHubSigma)
    R = rotation([1 - sigma @ sigma, *(2 * sigma)])
    return b.from_center(R, state(hub.nameOfHubPosition), state(hub.nameOfHubOmega), state(hub.nameOfHubVelocity))


serve(step)
