"""The potentials of PROTOCOL.md on a body: the covector -dV of the configuration. Standard library only.

    (-dV)_a = -d/ds V(g exp(s E_a))   at s = 0, with the matrices E_a of the basis

On SO(3) g is the rotation R; on SE(3) its first three rows are (R x).
"""
import math

KINDS = ["gravity", "buoyancy", "uniform-field", "gravity-gradient"]


def slope(q, term, time, g, moved):
    """The derivative of V along the motion with the velocity `moved` of the matrix g (both by rows)."""
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
    """-dV, the sum over the terms of the potential."""
    n, m = q["dimension"], q["size"]
    total = [0.0] * n
    for a in range(n) if q.get("potential") else ():
        along = q["basis"][a * m * m:(a + 1) * m * m]
        moved = [sum(g[r * m + j] * along[j * m + c] for j in range(m)) for r in range(m) for c in range(m)]
        total[a] = -sum(slope(q, term, time, g, moved) for term in q["potential"])
    return total
