"""geomstats, InvariantMetric on SO(3): the geodesic equation with a diagonal matrix, and with a full one, which has no effect."""
import os

os.environ.setdefault("GEOMSTATS_BACKEND", "numpy")
import geomstats
import numpy as np
from geomstats.geometry.invariant_metric import InvariantMetric
from geomstats.geometry.special_orthogonal import SpecialOrthogonal

from reference import J, W, hat

T = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
print("geomstats", geomstats.__version__)
for name, inertia in (("diagonal", J), ("full", T @ J @ T.T)):
    metric = InvariantMetric(SpecialOrthogonal(3, equip=False), inertia, left=True)
    rate = metric.geodesic_equation(np.stack([np.eye(3), hat(W)]))[1]
    print(name, "metric: dw/dt", [rate[2, 1], rate[0, 2], rate[1, 0]], "Euler's equation:", np.linalg.solve(inertia, np.cross(inertia @ W, W)))
    print("  <w, w>", metric.inner_product_at_identity(hat(W), hat(W)), "  2 w.Iw", 2 * W @ inertia @ W, "  2 w.w", 2 * W @ W)
