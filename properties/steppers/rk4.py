#!/usr/bin/env python3
"""The classical Runge-Kutta method on (mu, g), order 4: the shortest useful stepper. Standard library only.

d/dt mu_a = C^d_ba eta^b mu_d + f_a(t, eta) - (dV(t, g))_a,   dg/dt = g eta^a E_a,   eta = I^-1 (mu - b).
"""
import json
import math
import sys

KINDS = ["gravity", "buoyancy", "uniform-field", "gravity-gradient"]  # of potentials


def solve(matrix, right):
    """Gaussian elimination with pivoting; the matrix by rows."""
    n = len(right)
    rows = [matrix[a * n:(a + 1) * n] + [right[a]] for a in range(n)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda r: abs(rows[r][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for r in range(k + 1, n):
            factor = rows[r][k] / rows[k][k]
            rows[r] = [x - factor * y for x, y in zip(rows[r], rows[k])]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (rows[k][n] - sum(rows[k][j] * x[j] for j in range(k + 1, n))) / rows[k][k]
    return x


def polynomial(terms, n, time, eta):
    total = [0.0] * n
    for a, value, p, q, factors in terms:
        total[a] += value * math.cos(time) ** p * math.sin(time) ** q * math.prod(eta[i] for i in factors)
    return total


def force(q, time, eta, mu, coad):
    """The sum of the terms of the force, a covector."""
    n = q["dimension"]
    total = [0.0] * n
    for term in q["force"]:
        kind = term["kind"]
        if kind == "linear-drag":
            f = [-sum(term["matrix"][a * n + b] * eta[b] for b in range(n)) for a in range(n)]
        elif kind == "quadratic-drag":
            f = [sum(term["matrix"][a * n + b] * eta[b] for b in range(n)) for a in range(n)]
            size = math.sqrt(max(0.0, sum(x * y for x, y in zip(f, eta))))
            f = [-size * x for x in f]
        elif kind == "cubic-drag":
            square = sum(x * x for x in eta)
            f = [-term["q"] * square * x for x in eta]
        elif kind == "polynomial":
            f = polynomial(term["terms"], n, time, eta)
        elif kind == "orbit":
            f = coad(polynomial(term["zeta"], n, time, eta), mu)
        elif kind == "double-bracket":
            f = [term["alpha"] * x for x in coad(coad(eta, mu), mu)]
        elif kind == "metriplectic":
            f = [-term["beta"] * x for x in coad(eta, coad(eta, mu))]
        elif kind == "constant":
            f = term["value"]
        elif kind == "periodic":
            factor = math.cos(term["frequency"] * time + term["phase"])
            f = [factor * x for x in term["value"]]
        else:
            raise NotImplementedError("force " + kind)
        total = [x + y for x, y in zip(total, f)]
    return total


def slope(q, term, time, g, moved):
    """The derivative of a term of V where the matrix g has the velocity `moved`. On SO(3) g is the rotation R, on SE(3) its top is (R x)."""
    m, kind = q["size"], term["kind"]

    def row(matrix, r, v):
        return sum(matrix[r * m + c] * v[c] for c in range(3))

    if kind in ("gravity", "buoyancy"):  # the height of the point `center`
        rise = row(moved, 2, term["center"]) + (moved[2 * m + 3] if m == 4 else 0.0)
        return term["weight"] * rise if kind == "gravity" else -term["lift"] * rise
    if kind == "uniform-field":
        return -sum(term["field"][r] * row(moved, r, term["moment"]) for r in range(3))
    if kind == "gravity-gradient":
        n, rate = q["dimension"], term["rate"]
        direction = (math.cos(rate * time), math.sin(rate * time), 0.0)
        body, change = ([sum(direction[r] * matrix[r * m + c] for r in range(3)) for c in range(3)] for matrix in (g, moved))
        return 3 * rate * rate * sum(change[r] * q["inertia"][r * n + c] * body[c] for r in range(3) for c in range(3))
    raise NotImplementedError("potential " + kind)


def pull(q, time, g):
    """The covector -dV: (dV)_a is the derivative of V(g exp(s E_a)) by s at 0."""
    n, m = q["dimension"], q["size"]
    total = [0.0] * n
    for a in range(n) if q.get("potential") else ():
        along = q["basis"][a * m * m:(a + 1) * m * m]
        moved = [sum(g[r * m + j] * along[j * m + c] for j in range(m)) for r in range(m) for c in range(m)]
        total[a] = -sum(slope(q, term, time, g, moved) for term in q["potential"])
    return total


def step(q):
    if q["version"] > 3 or "lagrangian" in q:
        raise NotImplementedError("a later version of the protocol")
    if q.get("quartic"):
        raise NotImplementedError("a quartic term")
    n, m, h = q["dimension"], q["size"], q["step"]
    rotor = q.get("gyrostat", [0.0] * n)
    bracket = q["constants"]  # C^c_ab at (a n + b) n + c
    nonzero = [(a, b, c, bracket[(a * n + b) * n + c]) for a in range(n) for b in range(n) for c in range(n)
               if bracket[(a * n + b) * n + c] != 0.0]

    def coad(xi, mu):  # (ad*_xi mu)_a = C^d_ba xi^b mu_d
        out = [0.0] * n
        for b, a, d, value in nonzero:
            out[a] += value * xi[b] * mu[d]
        return out

    def rate(time, mu, g):
        eta = solve(q["inertia"], [x - b for x, b in zip(mu, rotor)])
        hat = [sum(eta[a] * q["basis"][a * m * m + k] for a in range(n)) for k in range(m * m)] if g else []
        dg = [sum(g[r * m + j] * hat[j * m + c] for j in range(m)) for r in range(m) for c in range(m)] if g else []
        dmu = [x + y + z for x, y, z in zip(coad(eta, mu), force(q, time, eta, mu, coad), pull(q, time, g))]
        return dmu, dg

    def shifted(x, k, factor):
        return [a + factor * b for a, b in zip(x, k)]

    t, mu, g = q["time"], q["mu"], q.get("g", [])
    k1 = rate(t, mu, g)
    k2 = rate(t + h / 2, shifted(mu, k1[0], h / 2), shifted(g, k1[1], h / 2))
    k3 = rate(t + h / 2, shifted(mu, k2[0], h / 2), shifted(g, k2[1], h / 2))
    k4 = rate(t + h, shifted(mu, k3[0], h), shifted(g, k3[1], h))
    for k, factor in ((k1, h / 6), (k2, h / 3), (k3, h / 3), (k4, h / 6)):
        mu, g = shifted(mu, k[0], factor), shifted(g, k[1], factor)
    return {"mu": mu, "g": g}


for number, line in enumerate(sys.stdin if __name__ == "__main__" else ()):  # `stages.py` imports the potentials
    try:
        answer = step(json.loads(line))
    except NotImplementedError as reason:
        answer = {"unsupported": str(reason)}
    if number == 0:  # once: random systems are drawn of these
        answer["supports"] = {"quartic": False, "potentials": KINDS}
    print(json.dumps(answer), flush=True)
