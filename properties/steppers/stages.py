"""A stepper that speaks the protocol of PROTOCOL.md: the forced variational Runge-Kutta-Munthe-Kaas method of several stages.

    python3 stages.py [TABLEAU [TOLERANCE [MISTAKE]]]

TABLEAU: gauss-1 to gauss-4, lobatto-iiia-2, -3, lobatto-iiib-2, -3, radau-iia-2, -3 (default: gauss-2). TOLERANCE: Newton's method stops at
this residual, relative to the momentum (0, the default: to round-off). Martin de Diego and Sato Martin de Almagro, Variational order for
forced Lagrangian systems II (2019), section 5.2, with tau = exp. The unknowns are H_1, ..., H_s:

    X_i = h sum_j a_ij H_j,   xi = h sum_j b_j H_j,   eta_i = dexp_(X_i) H_i,   P_i = I eta_i dexp_(X_i),
    G_i = I eta_i (the derivative of dexp_x H_i along x, at X_i) + f_i dexp_(X_i),   m = mu + h sum_j b_j f_j Ad_exp(X_j)^-1,
    f_i = f(t_i, eta_i) - dV(t_i, g exp(X_i)),
    P_i + h sum_j (b_j a_ji / b_i) G_j = m dexp_(-xi),     mu' = m Ad_exp(xi),     g' = g exp(xi).

MISTAKE, to show what `probe --variational TABLEAU` says about it; the first three keep the order of most of these tableaux:
    conjugate  b_j - a_ij for b_j a_ji / b_i: a instead of its conjugate
    index      the force of stage i for that of stage j in the equations of the stages
    start      the potential at g instead of that at g exp(X_j): no consistent method where there is one
    bernoulli  mu' = m dexp_(-xi) dexp_xi^-1, with the series of dexp^-1 cut after B_2
    left       g' = exp(xi) g
"""
import json
import math
import sys

from rk4 import KINDS, pull
from variational import System, expm, matmul, plus, row_times, solve, times_column, unit

NAME = sys.argv[1] if len(sys.argv) > 1 else "gauss-2"
TOLERANCE = float(sys.argv[2]) if len(sys.argv) > 2 else 0.0
MISTAKE = sys.argv[3] if len(sys.argv) > 3 else ""


def symmetric(*nodes):
    """Nodes in (0, 1) from those in (-1, 1) that are not negative."""
    return [0.5 * (1 + x) for x in sorted({-x for x in nodes} | set(nodes))]


NODES = {
    "gauss-1": symmetric(0.0),
    "gauss-2": symmetric(math.sqrt(1 / 3)),
    "gauss-3": symmetric(0.0, math.sqrt(3 / 5)),
    "gauss-4": symmetric(math.sqrt((15 - 2 * math.sqrt(30)) / 35), math.sqrt((15 + 2 * math.sqrt(30)) / 35)),
    "lobatto-iiia-2": [0.0, 1.0],
    "lobatto-iiia-3": [0.0, 0.5, 1.0],
    "radau-iia-2": [1 / 3, 1.0],
    "radau-iia-3": [(4 - math.sqrt(6)) / 10, (4 + math.sqrt(6)) / 10, 1.0],
}


def integrals(c, end):
    """The integrals from 0 to `end` of the Lagrange polynomials of the nodes."""
    values = []
    for j, node in enumerate(c):
        p = [1.0]  # coefficients, the constant first
        for k, other in enumerate(c):
            if k != j:
                shifted = [0.0] + p
                p = [(s - other * q) / (node - other) for s, q in zip(shifted, p + [0.0])]
        values.append(sum(q * end ** (k + 1) / (k + 1) for k, q in enumerate(p)))
    return values


def tableau(name):
    """a and b; of Lobatto IIIB the conjugate of IIIA."""
    c = NODES[name.replace("iiib", "iiia")]
    a, b = [integrals(c, x) for x in c], integrals(c, 1.0)
    if "iiib" in name:
        a = [[b[j] - b[j] * a[j][i] / b[i] for j in range(len(b))] for i in range(len(b))]
    return a, b


A, B = tableau(NAME)
STAGES = range(len(B))


def step(q):
    system = System(q)
    n, h, time, mu = system.n, q["step"], q["time"], q["mu"]
    scale = max(abs(v) for v in mu) or 1.0

    def combined(weights, vectors):
        return [sum(w * v[a] for w, v in zip(weights, vectors)) for a in range(n)]

    def stages(unknowns):
        """The residuals, m, xi, and b_i, t_i, eta_i, X_i of each stage."""
        rates = [unknowns[i * n:(i + 1) * n] for i in STAGES]
        xi = [h * v for v in combined(B, rates)]
        momenta, gradients, pulled, impulses, told = [], [], [], [], []
        for i in STAGES:
            x = [h * v for v in combined(A[i], rates)]
            dexp = system.dexp(x)
            eta = times_column(dexp, rates[i])
            momentum = times_column(system.inertia, eta)
            f = system.force(time + sum(A[i]) * h, eta)
            if q.get("potential"):
                turn = system.hat([0.0] * n if MISTAKE == "start" else x)
                g = [v for row in matmul(system.rows(q["g"], system.m), expm(turn)) for v in row]
                f = [v + w for v, w in zip(f, pull(q, time + sum(A[i]) * h, g))]
            transport = plus(unit(n), -1.0, matmul(system.ad(x), dexp))  # Ad_exp(x)^-1
            momenta.append(row_times(momentum, dexp))
            gradients.append(row_times(momentum, system.second(x, rates[i])))
            pulled.append(row_times(f, dexp))
            impulses.append(row_times(f, transport))
            told.append((B[i], time + sum(A[i]) * h, eta, x))
        m = [a + h * b for a, b in zip(mu, combined(B, impulses))]
        end = row_times(m, system.dexp([-v for v in xi]))
        residuals = []
        for i in STAGES:
            w = [B[j] - A[i][j] if MISTAKE == "conjugate" else B[j] * A[j][i] / B[i] for j in STAGES]
            forces = [pulled[i] if MISTAKE == "index" else pulled[j] for j in STAGES]
            coupled = combined(w + w, gradients + forces)
            residuals += [p + h * c - e for p, c, e in zip(momenta[i], coupled, end)]
        return residuals, m, xi, told

    # Newton's method with one Jacobian, by differences.
    unknowns = solve(system.inertia, mu) * len(B)
    size = max(abs(v) for v in unknowns) or 1.0
    residual, m, xi, told = stages(unknowns)
    columns = []
    for k in range(len(unknowns)):
        moved = list(unknowns)
        moved[k] += 1e-6 * size
        columns.append([(x - y) / (1e-6 * size) for x, y in zip(stages(moved)[0], residual)])
    jacobian, best = [list(row) for row in zip(*columns)], math.inf
    for _ in range(80):
        left = max(abs(v) for v in residual)
        if left <= TOLERANCE * scale or left >= 0.9 * best:  # as wanted, or at round-off
            break
        best = left
        unknowns = [v - d for v, d in zip(unknowns, solve(jacobian, residual))]
        residual, m, xi, told = stages(unknowns)
    if not left <= max(TOLERANCE, 1e-12) * scale * 16:
        return {"error": "Newton's method did not converge"}
    ad = system.ad(xi)
    answer = {"mu": row_times(m, expm(ad))}
    if MISTAKE == "bernoulli":
        inverse = plus(plus(unit(n), 0.5, ad), 1 / 12, matmul(ad, ad))
        answer["mu"] = row_times(row_times(m, system.dexp([-v for v in xi])), inverse)
    if "g" in q:
        g, increment = system.rows(q["g"], system.m), expm(system.hat(xi))
        g = matmul(increment, g) if MISTAKE == "left" else matmul(g, increment)
        answer["g"] = [v for row in g for v in row]
        start = system.rows(q["g"], system.m)
        answer["stages"] = [{"b": b, "t": t, "eta": eta, "g": [v for row in matmul(start, expm(system.hat(x))) for v in row]}
                            for b, t, eta, x in told]
    return answer


for number, line in enumerate(sys.stdin):
    try:
        answer = step(json.loads(line))
    except NotImplementedError as reason:
        answer = {"unsupported": str(reason)}
    except (OverflowError, ZeroDivisionError) as reason:
        answer = {"error": str(reason)}
    if number == 0:  # once: random systems are drawn of these
        answer["supports"] = {"quartic": False, "potentials": KINDS}
    print(json.dumps(answer), flush=True)
