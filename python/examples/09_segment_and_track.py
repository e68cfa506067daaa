# SPDX-License-Identifier: Apache-2.0
"""A drive with depth: where is the camera, and what stands there?

09_segment_and_track.py SEQUENCE [FRAMES]
"""

import sys

import estancia

drive = estancia.open_sequence(sys.argv[1])
assert drive.camera is not None, "the camera of the depth images is not known"
tracker = estancia.RgbdTracker(drive.camera)
for i in range(min(len(drive), int(sys.argv[2]) if len(sys.argv) > 2 else 20)):
    image, depth = drive.image(i), drive.depth(i)
    at = tracker.add(image, depth, drive[i].timestamp).pose
    things = estancia.find_clusters(depth, drive.camera, image).clusters
    print(f"{drive[i].name}: {f'{at.x:.2f} {at.y:.2f}' if at else 'lost'}, {len(things)} things")
