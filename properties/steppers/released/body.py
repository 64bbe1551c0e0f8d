"""Rigid bodies between the protocol of `probe` and the state that released software has. Needs numpy.

A body turns freely (SO(3), mass 1, its center at rest in the origin) or moves freely (SE(3)); `constant` forces of the protocol are
a torque and a force that are constant in the body frame. All numbers are taken from the request, none is assumed.
"""
import json
import os
import sys

import numpy as np

# Answers go to the standard output; what the software prints there goes to standard error. So import this module first.
ANSWERS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)


class Unsupported(Exception):
    """The software does not do this; the reason has no numbers."""


def hat(x):
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]], float)


def quaternion(R):
    """The unit quaternion (w, x, y, z) of a rotation: the row of the largest size of the matrix 4 q qᵀ."""
    (a, b, c), (d, e, f), (g, h, i) = R
    rows = np.array([[1 + a + e + i, h - f, c - g, d - b], [h - f, 1 + a - e - i, b + d, c + g],
                     [c - g, b + d, 1 - a + e - i, f + h], [d - b, c + g, f + h, 1 - a - e + i]])
    q = rows[np.argmax(np.diag(rows))]
    return q / np.linalg.norm(q)


def rotation(q):
    """The rotation of a quaternion (w, x, y, z) of any length but 0."""
    w, x, y, z = np.asarray(q, float) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class Body:
    """The body of a request.

    `R`, `p`: from the body to space, and where the body's origin is; `w`, `v`: angular velocity, and velocity of the origin, both in
    the body frame; `mass`, `center` (of mass, body frame), `J` about the center; `torque` about the origin and `force`, body frame.
    """

    def __init__(self, q):
        n, m, free = q["dimension"], q["size"], np.zeros(6)
        if q["version"] != 1 or q.get("quartic"):
            raise Unsupported("more than a kinetic energy")
        se3 = (n, m) == (6, 4)
        units = [np.zeros((m, m)) for _ in range(n)]
        for a in range(min(n, 3)):
            units[a][:3, :3] = hat(np.eye(3)[a]) if m >= 3 else 0
        for a in range(3, n if se3 else 3):
            units[a][a - 3, 3] = 1
        if (n, m) not in ((3, 3), (6, 4)) or not np.array_equal(np.ravel(units), q["basis"]):
            raise Unsupported("only SO(3) and SE(3) in their standard bases")
        self.inertia = np.reshape(q["inertia"], (n, n))
        self.se3, self.time, self.h = se3, q["time"], q["step"]
        for term in q["force"]:
            if term["kind"] != "constant":
                raise Unsupported("forces that are not constant in the body frame")
            free[:n] += term["value"]
        self.torque, self.force, self.is_free = free[:3], free[3:], not free.any()
        g, velocity = np.reshape(q["g"], (m, m)), np.linalg.solve(self.inertia, q["mu"])
        self.R, self.w = g[:3, :3], velocity[:3]
        self.p, self.v = (g[:3, 3], velocity[3:]) if se3 else (np.zeros(3), np.zeros(3))
        self.mass, self.center, self.J = 1.0, np.zeros(3), self.inertia[:3, :3]
        if se3:
            self.mass = self.inertia[3, 3]
            c = self.inertia[:3, 3:] / self.mass
            self.center = np.array([c[2, 1], c[0, 2], c[1, 0]])
            if not np.allclose(c, hat(self.center)) or not np.allclose(self.inertia[3:, 3:], self.mass * np.eye(3)):
                raise Unsupported("an inertia that no rigid body has")
            self.J = self.J + self.mass * hat(self.center) @ hat(self.center)
        moments = np.linalg.eigvalsh(self.J)
        if moments[0] <= 0 or moments[2] > moments[0] + moments[1]:
            raise Unsupported("an inertia that no rigid body has")

    def principal(self):
        """Q and d with J = Q diag(d) Qᵀ, Q a rotation."""
        if np.array_equal(self.J, np.diag(np.diag(self.J))):
            return np.eye(3), np.diag(self.J).copy()
        d, Q = np.linalg.eigh(self.J)
        return Q * np.linalg.det(Q).round(), d

    def at_center(self):
        """Position and velocity of the center of mass, in space."""
        return self.p + self.R @ self.center, self.R @ (self.v + np.cross(self.w, self.center))

    def from_center(self, R, x, w, u):
        """The answer for a rotation, position and velocity of the center in space, angular velocity in the body frame."""
        R, w = np.asarray(R, float), np.asarray(w, float)
        return R, x - R @ self.center, w, R.T @ u - np.cross(w, self.center)

    def answer(self, R, p, w, v):
        """The answer for the state in the terms of this class."""
        n = len(self.inertia)
        mu = self.inertia @ np.concatenate([w, v])[:n]
        g = np.array(R, float) if not self.se3 else np.vstack([np.column_stack([R, p]), [0, 0, 0, 1]])
        return {"mu": mu.tolist(), "g": g.ravel().tolist()}


# Random systems are drawn of these.
SUPPORTS = {"algebras": ["so3", "se3"], "standard_basis": True, "physical_inertia": True, "quartic": False, "forces": ["constant"]}


def serve(step):
    """Answers requests by `step(body)`, which returns R, p, w, v after the step."""
    for number, line in enumerate(sys.stdin):
        try:
            body = Body(json.loads(line))
            answer = body.answer(*step(body))
        except Unsupported as reason:
            answer = {"unsupported": str(reason)}
        if number == 0:
            answer["supports"] = SUPPORTS
        print(json.dumps(answer), file=ANSWERS, flush=True)
