# SPDX-License-Identifier: Apache-2.0
"""Finds a known object and its pose in a point cloud.

07_find_objects.py MODEL SCENE     (PCD or PLY)
"""

import sys

import estancia

recognizer = estancia.Recognizer({"object": estancia.read_cloud(sys.argv[1])})
for found in recognizer.detect(estancia.read_cloud(sys.argv[2])):
    x, y, z = found.center
    print(f"{found.model} at ({x:.3f}, {y:.3f}, {z:.3f}) m, confidence {found.confidence:.3f}")
