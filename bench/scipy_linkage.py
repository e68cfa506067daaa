# SPDX-License-Identifier: Apache-2.0
"""SciPy's answer for bench_linkage: python3 scipy_linkage.py ROWS.npy METRIC METHOD CLUSTERS.npy CUT…

Prints the seconds that pdist and linkage took, by the wall clock and of the processor; writes the flat clusters, a row a cut."""
import sys
import time

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import pdist


def clocks():
    return time.perf_counter(), time.process_time()


rows = np.load(sys.argv[1]).astype(np.float64)
start = clocks()
distances = pdist(rows, sys.argv[2])
middle = clocks()
merges = linkage(distances, sys.argv[3])
end = clocks()
clusters = [fcluster(merges, float(cut), "distance") for cut in sys.argv[5:]]
np.save(sys.argv[4], np.array(clusters, dtype=np.float32))
print(middle[0] - start[0], end[0] - middle[0], middle[1] - start[1], end[1] - middle[1])
