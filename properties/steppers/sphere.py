#!/usr/bin/env python3
"""A stepper whose state has no attitude: points that are moved by rotations, order 2. Standard library only.

    d/dt mu = mu x w + alpha mu x (mu x w),   dx/dt = x x w,   w = I^-1 mu     (a free body, or Landau-Lifshitz-Gilbert damping)

mu is a point of its coadjoint orbit, the sphere |mu| = const; x = g^-1 x_0 is a point of S^2, a direction that is fixed in space as
the body sees it. Both are turned by the midpoint rule with exp, so that they stay on their spheres to round-off.

    sphere.py             the state is (mu, x), x_0 = e_3
    sphere.py momentum    the state is mu alone
    sphere.py frozen      a mistake: x is turned by the velocity at the start of the step, as with coordinates that are frozen there
"""
import json
import math
import sys

MODE = sys.argv[1] if len(sys.argv) > 1 else ""
SUPPORTS = {"algebras": ["so3"], "standard_basis": True, "quartic": False, "forces": ["double-bracket"],
            "state": "momentum" if MODE == "momentum" else {"point": [0.0, 0.0, 1.0]}}


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def plus(a, factor, b):
    return [x + factor * y for x, y in zip(a, b)]


def solve(rows, b):
    """Cramer's rule for a 3x3 matrix by rows."""
    p, q, r = rows[0:3], rows[3:6], rows[6:9]
    qr, rp, pq = cross(q, r), cross(r, p), cross(p, q)
    return [(b[0] * qr[k] + b[1] * rp[k] + b[2] * pq[k]) / dot(p, qr) for k in range(3)]


def turned(v, w):
    """exp(-hat(w)) v: the solution of dv/dt = v x w after the time 1."""
    angle = math.sqrt(dot(w, w))
    if angle == 0.0:
        return v
    axis = [x / angle for x in w]
    return plus(plus([math.cos(angle) * x for x in v], math.sin(angle), cross(v, axis)),
                2.0 * math.sin(angle / 2.0) ** 2 * dot(axis, v), axis)


def velocities(q, mu):
    """The velocity of the body, and that with which mu turns."""
    w = solve(q["inertia"], mu)
    alpha = sum(term["alpha"] for term in q["force"])
    return w, plus(w, alpha, cross(mu, w))


def step(q):
    h, mu = q["step"], q["mu"]
    start, turn = velocities(q, mu)
    middle = turned(mu, [h / 2.0 * x for x in turn])
    w, turn = velocities(q, middle)
    answer = {"mu": turned(mu, [h * x for x in turn])}
    if "x" in q:
        answer["x"] = turned(q["x"], [h * x for x in (start if MODE == "frozen" else w)])
    return answer


def known(q):
    so3 = [0, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0]
    damped = all(term["kind"] == "double-bracket" for term in q["force"])
    return q["version"] == 1 and q["constants"] == so3 and not q.get("quartic") and damped and "g" not in q


for number, line in enumerate(sys.stdin):
    q = json.loads(line)
    answer = step(q) if known(q) else {"unsupported": "anything but a free or damped body on SO(3)"}
    if number == 0:  # once: random systems are drawn of these, and have this state
        answer["supports"] = SUPPORTS
    print(json.dumps(answer), flush=True)
