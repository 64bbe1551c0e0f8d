#!/usr/bin/env python3
"""A body for software that has no Python: COMMAND reads and writes a line of numbers for each step.

It reads h, mass, the three principal moments; then, of the principal frame at the center of mass, the unit quaternion (w, x, y, z)
of its attitude, its angular velocity in space, its position and its velocity in space. It writes the last thirteen after the step.
"""
import subprocess
import sys

import numpy as np

from body import Unsupported, quaternion, rotation, serve

PROGRAM = subprocess.Popen(sys.argv[1:], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def step(b):
    if not b.is_free:
        raise Unsupported("forces")
    Q, d = b.principal()
    x, u = b.at_center()
    numbers = [b.h, b.mass, *d, *quaternion(b.R @ Q), *(b.R @ b.w), *x, *u]
    PROGRAM.stdin.write(" ".join(repr(float(x)) for x in numbers) + "\n")
    PROGRAM.stdin.flush()
    after = np.array(PROGRAM.stdout.readline().split(), float)
    if len(after) != 13:
        raise Unsupported("a step that the software refuses")
    R = rotation(after[:4]) @ Q.T
    return b.from_center(R, after[7:10], R.T @ after[4:7], after[10:])


serve(step)
