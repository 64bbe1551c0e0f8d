"""Crocoddyl, IntegratedActionModelRK: two, three and four stages have order 2 in the attitude."""
import crocoddyl
import numpy as np
import pinocchio as pin

from reference import J, W, rotation, show

model = pin.Model()
model.appendBodyToJoint(model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body"),
                        pin.Inertia(1.0, np.zeros(3), J), pin.SE3.Identity())
model.gravity.linear = np.zeros(3)
state = crocoddyl.StateMultibody(model)
actuation = crocoddyl.ActuationModelFloatingBase(state)
motion = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, crocoddyl.CostModelSum(state, actuation.nu))

for stages in ("two", "three", "four"):
    def run(n):
        action = crocoddyl.IntegratedActionModelRK(motion, getattr(crocoddyl.RKType, stages), 1 / n)
        data, x = action.createData(), np.array([0, 0, 0, 0, 0, 0, 1, 0, 0, 0, *W], float)
        for _ in range(n):
            action.calc(data, x, np.zeros(actuation.nu))
            x = data.xnext.copy()
        return rotation(x[6], *x[3:6]), x[10:]
    print("Crocoddyl", crocoddyl.__version__, stages)
    show(run)
