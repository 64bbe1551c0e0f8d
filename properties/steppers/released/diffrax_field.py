#!/usr/bin/env python3
"""diffrax, in 64 bits: `diffeqsolve` with one constant step. Arguments: the solver, and `matrix` or `quaternion`."""
import sys

from body import serve

import diffrax
import jax
import jax.numpy as jnp

import field

jax.config.update("jax_enable_x64", True)
SOLVER, KIND = sys.argv[1:]


@jax.jit
def solve(inertia, torque, force, time, h, y):
    term = diffrax.ODETerm(lambda t, y, _: field.rate(jnp, KIND, inertia, torque, force, y))
    tight = {"root_finder": diffrax.VeryChord(rtol=1e-13, atol=1e-14)} if issubclass(
        getattr(diffrax, SOLVER), diffrax.AbstractImplicitSolver) else {}
    solver = getattr(diffrax, SOLVER)(**tight)
    return diffrax.diffeqsolve(term, solver, time, time + h, h, y, stepsize_controller=diffrax.ConstantStepSize(),
                               max_steps=2).ys[0]


def step(b):
    return field.state(b, KIND, solve(b.inertia, b.torque, b.force, b.time, b.h, field.start(b, KIND)))


serve(step)
