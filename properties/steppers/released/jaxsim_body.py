#!/usr/bin/env python3
"""JaxSim, in 64 bits: a floating body, jaxsim.api.model.step. Argument: the integrator."""
import os
import sys

from body import Unsupported, quaternion, rotation, serve

os.environ["JAX_ENABLE_X64"] = "1"
import jax
import jaxsim.api as js
import numpy as np
from jaxsim import VelRepr
from jaxsim.api.model import IntegratorType

MODELS, STEP = {}, jax.jit(js.model.step)
SDF = """<sdf version="1.7"><model name="body"><link name="body"><inertial><pose>{c} 0 0 0</pose><mass>{m!r}</mass><inertia>
<ixx>{J[0][0]!r}</ixx><ixy>{J[0][1]!r}</ixy><ixz>{J[0][2]!r}</ixz><iyy>{J[1][1]!r}</iyy><iyz>{J[1][2]!r}</iyz><izz>{J[2][2]!r}</izz>
</inertia></inertial></link></model></sdf>"""


def step(b):
    if not b.is_free:
        raise Unsupported("forces")
    text = SDF.format(c=" ".join(map(repr, b.center.tolist())), m=float(b.mass), J=b.J.tolist())
    if text not in MODELS:
        MODELS[text] = js.model.JaxSimModel.build_from_model_description(
            text, gravity=0.0, integrator=getattr(IntegratorType, sys.argv[1]))
    model = MODELS[text]
    with model.editable(validate=False) as model:
        model.time_step = b.h
    data = js.data.JaxSimModelData.build(
        model, base_position=b.p, base_quaternion=quaternion(b.R), base_linear_velocity=b.v, base_angular_velocity=b.w,
        velocity_representation=VelRepr.Body)
    data = STEP(model, data)
    with data.switch_velocity_representation(VelRepr.Body):
        v = np.array(data.base_velocity)
    return rotation(data.base_quaternion), np.array(data.base_position), v[3:], v[:3]


serve(step)
