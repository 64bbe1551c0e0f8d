#!/usr/bin/env python3
"""A free rigid body by the classical Runge-Kutta method: the stepper of the README. Standard library only."""
import json
import sys


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rate(q, y):
    mu, g = y[:3], y[3:]
    w = [mu[a] / q["inertia"][4 * a] for a in range(3)]  # diagonal inertia
    rows = [cross(g[3 * r:3 * r + 3], w) for r in range(3)]  # dg/dt = g hat(w), row by row
    return cross(mu, w) + rows[0] + rows[1] + rows[2]


def step(q):
    so3 = [0, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0]
    diagonal = all(x == 0 for k, x in enumerate(q["inertia"]) if k % 4)
    free = q["version"] == 1 and not q.get("quartic") and not q["force"]
    if q["constants"] != so3 or q["size"] != 3 or not diagonal or not free:
        return {"unsupported": "anything but a free rigid body in its principal axes"}
    y, h = q["mu"] + q["g"], q["step"]
    k1 = rate(q, y)
    k2 = rate(q, [a + h / 2 * b for a, b in zip(y, k1)])
    k3 = rate(q, [a + h / 2 * b for a, b in zip(y, k2)])
    k4 = rate(q, [a + h * b for a, b in zip(y, k3)])
    y = [a + h / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(y, k1, k2, k3, k4)]
    return {"mu": y[:3], "g": y[3:]}


for number, line in enumerate(sys.stdin):
    answer = step(json.loads(line))
    if number == 0:  # once: random systems are drawn of these
        answer["supports"] = {"algebras": ["so3"], "standard_basis": True, "diagonal_inertia": True, "quartic": False, "forces": []}
    print(json.dumps(answer), flush=True)
