# SPDX-License-Identifier: Apache-2.0
"""Growing Neural Gas takes the noise off a point cloud.

08_denoise_a_cloud.py INPUT OUTPUT     (PCD or PLY)
"""

import sys

import estancia

cloud = estancia.read_cloud(sys.argv[1])
print(f"{len(cloud)} points, spacing {cloud.resolution():.4f} m, noise {cloud.noise():.4f} m")
clean = estancia.filter_cloud(cloud, method="gng", points=min(2000, len(cloud) // 2))
clean.write(sys.argv[2])
print(f"{len(clean)} neurons, noise {clean.noise():.4f} m")
