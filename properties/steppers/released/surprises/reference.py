"""A free body turns for one unit of time: what the software says, against a fine solution. Without the adapters and without `probe`."""
import numpy as np

J, W = np.diag([0.6, 1.0, 1.3]), np.array([0.9, -0.5, 0.7])


def hat(x):
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])


def rotation(w, x, y, z):
    u, s = np.array([x, y, z]), np.sqrt(w * w + x * x + y * y + z * z)
    return np.eye(3) + 2 * (w * hat(u) + hat(u) @ hat(u)) / s**2


def exact(steps=4000):
    """R, and the momentum in the body frame at time 1: the classical Runge-Kutta method in small steps."""
    def rate(R, m):
        w = np.linalg.solve(J, m)
        return R @ hat(w), np.cross(m, w)
    R, m, h = np.eye(3), J @ W, 1 / steps
    for _ in range(steps):
        k1 = rate(R, m)
        k2 = rate(R + h / 2 * k1[0], m + h / 2 * k1[1])
        k3 = rate(R + h / 2 * k2[0], m + h / 2 * k2[1])
        k4 = rate(R + h * k3[0], m + h * k3[1])
        R = R + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        m = m + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
    return R, m


def show(run, steps=(8, 16, 32, 64, 128)):
    """Errors at time 1 of `run(n)`, which makes n steps and returns R and the angular velocity in the body frame."""
    R, m = exact()
    last = None
    for n in steps:
        mine, w = run(n)
        errors = np.abs(mine - R).max(), np.abs(J @ w - m).max()
        orders = [f"{np.log2(a / b):.2f}" for a, b in zip(last, errors)] if last else ["", ""]
        last = errors
        print(f"{n:5} steps: attitude {errors[0]:.2e} {orders[0]:5} momentum {errors[1]:.2e} {orders[1]}")
