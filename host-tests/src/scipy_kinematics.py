"""Times scipy's solvers on forward kinematics, as somebody would write it with numpy.

Reads {"lower", "upper": six hinges each, m, "start": [x, y, z], m, "lengths": six for each pose, m} as JSON on standard
input, axes with Y up. Every pose is solved from the start, by root (Powell's hybrid method) and by least_squares.
Prints ns per solve and the largest residual left, m.
"""

import json
import sys
import time

import numpy as np
from scipy.optimize import least_squares, root

base = json.load(sys.stdin)
lower, upper = np.array(base["lower"]), np.array(base["upper"])
start = np.array(base["start"] + [0.0, 0.0, 0.0])


def rotation(roll, yaw, pitch):
    (sg, cg), (sp, cp), (st, ct) = ((np.sin(a), np.cos(a)) for a in (roll, yaw, pitch))
    return np.array(
        [
            [cp * ct, sp * sg - cp * st * cg, sp * cg + cp * st * sg],
            [st, ct * cg, -ct * sg],
            [-sp * ct, cp * sg + sp * st * cg, cp * cg - sp * st * sg],
        ]
    )


def misfit(q, lengths):
    jacks = q[:3] + upper @ rotation(*q[3:]).T - lower
    return np.sqrt((jacks * jacks).sum(axis=1)) - lengths


def measure(solve):
    """Median time of a solve, ns, and the largest residual, m."""
    times, worst = [], 0.0
    for lengths in np.array(base["lengths"]):
        begun = time.perf_counter_ns()
        q = solve(lengths)
        times.append(time.perf_counter_ns() - begun)
        worst = max(worst, np.abs(misfit(q, lengths)).max())
    return float(np.median(times)), float(worst)


root_ns, root_residual_m = measure(lambda l: root(misfit, start, args=(l,), method="hybr").x)
fit_ns, fit_residual_m = measure(lambda l: least_squares(misfit, start, args=(l,)).x)
figures = {
    "root_ns": root_ns,
    "root_residual_m": root_residual_m,
    "least_squares_ns": fit_ns,
    "least_squares_residual_m": fit_residual_m,
}
print(json.dumps(figures))
