# SPDX-License-Identifier: Apache-2.0
"""scikit-learn's side of bench_classify: python3 sklearn_classify.py knn|svm TRAIN.npy CLASSES.npy TEST.npy PARAMETERS OUT.npy

PARAMETERS are K for knn (Euclidean, votes weigh 1/distance) and C,GAMMA for svm. Writes the predicted classes; prints the seconds of
the prediction, best of three, by the wall clock and of the processor, the number of support vectors, and which BLAS NumPy uses."""
import os
import sys
import time

import numpy as np
from sklearn.neighbors import KNeighborsClassifier
from sklearn.svm import SVC

kind, train, classes, test, parameters, out = sys.argv[1:]
x, y, queries = (np.load(f).astype(np.float64) for f in (train, classes, test))  # as scikit-learn's users have them
if kind == "knn":
    model = KNeighborsClassifier(int(parameters), weights="distance").fit(x, y.ravel())
    vectors = len(x)
else:
    c, gamma = map(float, parameters.split(","))
    model = SVC(C=c, gamma=gamma).fit(x, y.ravel())
    vectors = len(model.support_)
wall = cpu = float("inf")
for _ in range(3):
    start = time.perf_counter(), time.process_time()
    answer = model.predict(queries)
    wall = min(wall, time.perf_counter() - start[0])
    cpu = min(cpu, time.process_time() - start[1])
np.save(out, answer.reshape(-1, 1).astype(np.float32))
libraries = {line.split()[-1] for line in open("/proc/self/maps") if "/libblas.so" in line}
print(wall, cpu, vectors, next((os.path.basename(os.path.dirname(file)) for file in libraries), "unknown-BLAS"))
