# SPDX-License-Identifier: Apache-2.0
"""Writes scipy_linkage.json, what SciPy says about inputs that test_scipy.cpp makes anew.

    python3 tests/stats/scipy_linkage.py > tests/stats/scipy_linkage.json     (python3-scipy 1.10 of Debian 12)
"""
import json

import numpy as np
import scipy
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import pdist

from scipy_random import Random

METHODS = ["single", "complete", "average", "weighted", "ward"]


def descriptors(seed, items, labels, places):
    """Item i varies the distribution of place i % places; float32."""
    random = Random(seed)
    centers = [[random.uniform() for _ in range(labels)] for _ in range(places)]
    rows = []
    for i in range(items):
        row = [c * c * c * (0.5 + random.uniform()) for c in centers[i % places]]
        total = 0.0
        for value in row:
            total += value
        rows.append([value / total for value in row])
    return np.array(rows, dtype=np.float32).astype(np.float64)


def dissimilarities(seed, items, steps):
    """All pairs at random, on so few values that most are ties."""
    random = Random(seed)
    return np.array([int(random.uniform() * steps) / steps for _ in range(items * (items - 1) // 2)])


def digest(numbers):
    """FNV-1a over numbers of 32 bits, as text."""
    value = 0xCBF29CE484222325
    for number in numbers:
        for byte in int(number).to_bytes(4, "little"):
            value = (value ^ byte) * 0x100000001B3 % 2**64
    return f"{value:016x}"


def partition(clusters):
    """Cluster numbers in order of first appearance."""
    names = {}
    return [names.setdefault(c, len(names)) for c in clusters]


def cuts(merges):
    """Distances in the middle of the widest gaps between heights that leave few and many clusters."""
    heights = merges[:, 2]
    items = len(heights) + 1
    found = []
    for least, most in [(2, 22), (23, 40), (60, 200), (300, 800)]:
        gap, clusters = max((heights[items - c] - heights[items - c - 1], c) for c in range(least, most))
        assert gap > 1e-5, "too narrow for float32"
        distance = float((heights[items - clusters] + heights[items - clusters - 1]) / 2)
        labels = partition(fcluster(merges, distance, "distance"))
        assert max(labels) + 1 == clusters
        found.append({"distance": distance, "clusters": clusters, "digest": digest(labels)})
    return found


result = {"scipy": scipy.__version__}

rows = descriptors(1, 12, 7, 3)
metrics = ["chebyshev", "cityblock", "euclidean", "cosine", "correlation", "jensenshannon"]
result["distances"] = {metric: [round(float(d), 9) for d in pdist(rows, metric)] for metric in metrics}

distances = pdist(descriptors(2, 30, 5, 4), "euclidean")
result["small"] = {method: [[float(f"{v:.12g}") for v in merge] for merge in linkage(distances, method)] for method in METHODS}

result["ties"] = []
for seed, items, steps in [(3, 20, 4), (4, 77, 10), (5, 300, 50), (6, 500, 1)]:
    case = {"seed": seed, "items": items, "steps": steps, "digests": {}}
    for method in METHODS:
        merges = linkage(dissimilarities(seed, items, steps), method)
        case["digests"][method] = digest(merges[:, [0, 1, 3]].astype(int).ravel())
    result["ties"].append(case)

result["large"] = []
for seed, metric in [(7, "chebyshev"), (8, "euclidean"), (9, "cosine")]:
    distances = pdist(descriptors(seed, 1000, 40, 23), metric)
    case = {"seed": seed, "metric": metric, "cuts": {}}
    for method in METHODS:
        if method != "ward" or metric == "euclidean":
            case["cuts"][method] = cuts(linkage(distances, method))
    result["large"].append(case)

print(json.dumps(result, separators=(",", ":")).replace('],"', '],\n"').replace('},"', '},\n"').replace("],[", "],\n["))
