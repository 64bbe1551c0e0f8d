#!/usr/bin/env python3
"""The forced variational midpoint method (Gauss-1, exp) on any Lie algebra, order 2. Standard library only.

D. Martin de Diego, R. T. Sato Martin de Almagro, Variational order for forced Lagrangian systems II (2019), section 5.2,
with one stage: a_11 = 1/2, b_1 = 1. The unknown is the velocity H of the stage:

    X = h H / 2,   xi = h H,   eta = dexp_X H = H,   P = I H dexp_X,   f at the midpoint,
    m = mu + h f Ad_exp(X)^-1,
    P + (h/2) (P ddexp_X(H, .) + f dexp_X) = m dexp_(-xi),     mu' = m Ad_exp(xi),     g' = g exp(xi).

Covectors are rows: mu A is a sum over rows of A. Without a force every Casimir is kept to round-off.

With an argument it makes a mistake, to show what `probe` says about it:
    adjoint   mu' = m Ad_exp(xi)^-1, the coadjoint action inverted
    frozen    the force at the start of the step instead of that at the midpoint
    left      g' = exp(xi) g, the increment on the wrong side
    axis      the first component of mu' a little too large
"""
import json
import math
import sys
from operator import mul

MISTAKE = sys.argv[1] if len(sys.argv) > 1 else ""


def unit(n):
    return [[1.0 if r == c else 0.0 for c in range(n)] for r in range(n)]


def matmul(a, b):
    columns = list(zip(*b))
    return [[sum(map(mul, row, column)) for column in columns] for row in a]


def plus(a, factor, b):
    """a + factor * b."""
    return [[x + factor * y for x, y in zip(p, q)] for p, q in zip(a, b)]


def entries(matrices):
    """For each row and column the entries of all matrices there."""
    return [list(zip(*rows)) for rows in zip(*matrices)]


def combine(factors, table):
    """The sum of factor * matrix, for the entries of the matrices."""
    return [[sum(map(mul, factors, entry)) for entry in row] for row in table]


def row_times(mu, a):
    return [sum(map(mul, mu, column)) for column in zip(*a)]


def times_column(a, x):
    return [sum(map(mul, row, x)) for row in a]


def series(a, coefficient):
    """sum_k coefficient(k) a^k, for a of moderate size."""
    total, power, k = unit(len(a)), unit(len(a)), 0
    total = [[coefficient(0) * x for x in row] for row in total]
    while k < 60:
        k += 1
        power = matmul(power, a)
        c = coefficient(k)
        total = plus(total, c, power)
        if abs(c) * max(max(map(abs, row)) for row in power) < 1e-20:
            break
    return total


def expm(a):
    """The matrix exponential: a / 2^j small, the series, j squarings."""
    size, j = max(sum(abs(x) for x in row) for row in a), 0
    while size > 0.5:
        size, j = size / 2, j + 1
    result = series([[x / 2 ** j for x in row] for row in a], lambda k: 1 / math.factorial(k))
    for _ in range(j):
        result = matmul(result, result)
    return result


def solve(matrix, right):
    n = len(right)
    rows = [list(matrix[a]) + [right[a]] for a in range(n)]
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


class System:
    def __init__(self, q):
        n = self.n = q["dimension"]
        self.m = q["size"]
        if q["version"] not in (1, 3) or any(key in q for key in ("metric", "gyrostat", "lagrangian")):
            raise NotImplementedError("a later version of the protocol")
        if q.get("quartic"):
            raise NotImplementedError("a quartic term")
        table = q["constants"]
        # Of the matrices of ad_(e_a): row c, column b holds C^c_ab.
        self.ad_basis = entries([[[table[(a * n + b) * n + c] for b in range(n)] for c in range(n)] for a in range(n)])
        self.inertia = self.rows(q["inertia"], n)
        m = self.m
        self.basis = entries([self.rows(q["basis"][a * m * m:(a + 1) * m * m], m) for a in range(n)]) if m else []
        self.terms = q["force"]

    @staticmethod
    def rows(flat, n):
        return [flat[r * n:(r + 1) * n] for r in range(len(flat) // n)]

    def ad(self, x):
        return combine(x, self.ad_basis)

    def hat(self, x):
        return combine(x, self.basis)

    def dexp(self, x):
        """dexp_x = sum_k (-ad_x)^k / (k + 1)!, the left-trivialised tangent."""
        ad = [[-v for v in row] for row in self.ad(x)]
        return series(ad, lambda k: 1 / math.factorial(k + 1))

    def second(self, x, y):
        """dexp_x ddexp_x(y, .), the derivative of dexp_x y along x, as a matrix."""
        # D_k = d/dx (ad_x^k y): D_k = ad_x D_(k-1) - ad_(w_(k-1)), w_k = ad_x w_(k-1).
        ad, w = self.ad(x), list(y)
        d = [[0.0] * self.n for _ in range(self.n)]
        total = [[0.0] * self.n for _ in range(self.n)]
        for k in range(1, 40):
            d = plus(matmul(ad, d), -1.0, self.ad(w))
            w = times_column(ad, w)
            c = (-1) ** k / math.factorial(k + 1)
            total = plus(total, c, d)
            if abs(c) * max(max(map(abs, row)) for row in d) < 1e-20:
                break
        return total

    def force(self, time, eta):
        mu = times_column(self.inertia, eta)
        total = [0.0] * self.n
        for term in self.terms:
            kind = term["kind"]
            if kind in ("linear-drag", "quadratic-drag"):
                f = times_column(self.rows(term["matrix"], self.n), eta)
                size = math.sqrt(max(0.0, sum(x * y for x, y in zip(f, eta)))) if kind == "quadratic-drag" else 1.0
                f = [-size * x for x in f]
            elif kind == "double-bracket":
                zeta = row_times(mu, self.ad(eta))
                f = [term["alpha"] * x for x in row_times(mu, self.ad(zeta))]
            elif kind == "metriplectic":
                ad = self.ad(eta)
                f = [-term["beta"] * x for x in row_times(row_times(mu, ad), ad)]
            elif kind == "cubic-drag":
                f = [-term["q"] * sum(x * x for x in eta) * x for x in eta]
            elif kind == "polynomial":
                f = polynomial(term["terms"], self.n, time, eta)
            elif kind == "orbit":
                f = row_times(mu, self.ad(polynomial(term["zeta"], self.n, time, eta)))
            elif kind == "constant":
                f = term["value"]
            elif kind == "periodic":
                factor = math.cos(term["frequency"] * time + term["phase"])
                f = [factor * x for x in term["value"]]
            else:
                raise NotImplementedError("force " + kind)
            total = [x + y for x, y in zip(total, f)]
        return total


def step(q):
    system = System(q)
    if q.get("potential"):
        raise NotImplementedError("a potential")
    n, h, time, mu = system.n, q["step"], q["time"], q["mu"]
    start = solve(system.inertia, mu)

    def stage(velocity):
        """The residual, m, and xi."""
        x, xi = [0.5 * h * v for v in velocity], [h * v for v in velocity]
        frozen = MISTAKE == "frozen"
        f = system.force(time if frozen else time + 0.5 * h, start if frozen else velocity)
        dexp = system.dexp(x)
        momentum = times_column(system.inertia, velocity)  # at the stage: dexp_X H = H, because X is a multiple of H
        p = row_times(momentum, dexp)
        # P ddexp_X(H, .) with P = M dexp_X is M times the derivative of dexp.
        gradient = [a + b for a, b in zip(row_times(momentum, system.second(x, velocity)), row_times(f, dexp))]
        # Ad_exp(X)^-1 = exp(-ad_X) = 1 - ad_X dexp_X.
        transport = plus(unit(n), -1.0, matmul(system.ad(x), dexp))
        m = [a + h * b for a, b in zip(mu, row_times(f, transport))]
        end = row_times(m, system.dexp([-v for v in xi]))
        return [p[a] + 0.5 * h * gradient[a] - end[a] for a in range(n)], m, xi

    # Newton's method with one Jacobian, by differences: each iteration gains a factor of the order of h.
    velocity, best = list(start), math.inf
    scale = max(abs(v) for v in start) or 1.0
    residual, m, xi = stage(velocity)
    jacobian = [[0.0] * n for _ in range(n)]
    for b in range(n):
        moved = list(velocity)
        moved[b] += 1e-6 * scale
        shifted = stage(moved)[0]
        for a in range(n):
            jacobian[a][b] = (shifted[a] - residual[a]) / (1e-6 * scale)
    for _ in range(60):
        velocity = [v - d for v, d in zip(velocity, solve(jacobian, residual))]
        residual, m, xi = stage(velocity)
        size = max(abs(v) for v in residual)
        if size == 0.0 or size >= 0.9 * best:  # at round-off
            break
        best = size
    if size > 1e-10 * (1.0 + max(abs(v) for v in mu)):
        return {"error": "Newton's method did not converge"}
    ad = system.ad(xi)
    if MISTAKE == "adjoint":
        ad = [[-v for v in row] for row in ad]
    answer = {"mu": row_times(m, expm(ad))}
    if MISTAKE == "axis":
        answer["mu"][0] *= 1 + h * h * h
    if "g" in q:
        g, increment = system.rows(q["g"], system.m), expm(system.hat(xi))
        g = matmul(increment, g) if MISTAKE == "left" else matmul(g, increment)
        answer["g"] = [v for row in g for v in row]
    return answer


def main():
    for number, line in enumerate(sys.stdin):
        try:
            answer = step(json.loads(line))
        except NotImplementedError as reason:
            answer = {"unsupported": str(reason)}
        except (OverflowError, ZeroDivisionError) as reason:
            answer = {"error": str(reason)}
        if number == 0:  # once: random systems are drawn of these
            answer["supports"] = {"quartic": False}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
