"""SciPy's answer for bench_linkage: python3 scipy_linkage.py ROWS.npy METRIC METHOD CLUSTERS.npy CUT…

Prints the seconds that pdist and linkage took; writes the flat clusters, a row a cut."""
import sys
import time

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import pdist

rows = np.load(sys.argv[1]).astype(np.float64)
start = time.perf_counter()
distances = pdist(rows, sys.argv[2])
middle = time.perf_counter()
merges = linkage(distances, sys.argv[3])
end = time.perf_counter()
clusters = [fcluster(merges, float(cut), "distance") for cut in sys.argv[5:]]
np.save(sys.argv[4], np.array(clusters, dtype=np.float32))
print(middle - start, end - middle)
