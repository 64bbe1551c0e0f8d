"""MuJoCo and MJX, both with RK4: order 4 and order 2 in the attitude."""
import jax
import mujoco
from mujoco import mjx

from reference import J, W, rotation, show

jax.config.update("jax_enable_x64", True)
XML = """<mujoco><option integrator="RK4" gravity="0 0 0"/><worldbody><body><freejoint/>
<inertial pos="0 0 0" mass="1" diaginertia="{} {} {}"/></body></worldbody></mujoco>""".format(*J.diagonal())


def with_mujoco(n):
    model = mujoco.MjModel.from_xml_string(XML)
    model.opt.timestep = 1 / n
    data = mujoco.MjData(model)
    data.qvel[3:] = W
    for _ in range(n):
        mujoco.mj_step(model, data)
    return rotation(*data.qpos[3:]), data.qvel[3:]


def with_mjx(n):
    model = mujoco.MjModel.from_xml_string(XML)
    model.opt.timestep = 1 / n
    model = mjx.put_model(model)
    data = mjx.make_data(model)
    data = data.replace(qvel=data.qvel.at[3:].set(W))
    data = jax.jit(lambda data: jax.lax.fori_loop(0, n, lambda _, d: mjx.step(model, d), data))(data)
    return rotation(*map(float, data.qpos[3:])), [float(x) for x in data.qvel[3:]]


print("MuJoCo", mujoco.__version__)
show(with_mujoco)
print("MJX")
show(with_mjx)
