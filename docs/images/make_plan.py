# SPDX-License-Identifier: Apache-2.0
"""Draws the made-up floor plan of the demo's tour, a rotunda of eighteen rooms: make_plan.py PLAN.png (32 m × 32 m)."""
import sys

import numpy as np
from skimage import io

PIXELS, HALF, ROOMS, INNER, OUTER = 60, 16, 18, 8.8, 14.2  # pixels a meter; meters

y, x = np.mgrid[0:2 * HALF * PIXELS, 0:2 * HALF * PIXELS]
x, y = (x + .5) / PIXELS - HALF, HALF - (y + .5) / PIXELS
radius, turn = np.hypot(x, y), np.arctan2(y, x) / (2 * np.pi) * ROOMS
off = (turn + .5) % 1 - .5  # -0.5 … 0.5 across a room
along = np.abs(off) * 2 * np.pi / ROOMS * radius
door = np.where(along > .55, np.abs(radius - INNER), np.hypot(along - .55, radius - INNER))
between = np.where((radius > INNER) & (radius < OUTER), (.5 - np.abs(off)) * 2 * np.pi / ROOMS * radius, np.inf)
distance = np.minimum.reduce([np.abs(radius - OUTER), door, between])
wall = np.clip((.09 - distance) * PIXELS + .5, 0, 1)[..., None]
floor = np.where((radius < OUTER)[..., None], np.array([252, 251, 247.]), 255.)
io.imsave(sys.argv[1], (floor * (1 - wall) + np.array([120, 118, 112.]) * wall).astype(np.uint8), check_contrast=False)
