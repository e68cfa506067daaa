# SPDX-License-Identifier: Apache-2.0
"""Writes sklearn_classify.json, what scikit-learn says about samples that test_sklearn.cpp makes anew.

    python3 tests/classify/sklearn_classify.py > tests/classify/sklearn_classify.json     (python3-sklearn 1.2 of Debian 12)
"""
import json

import numpy as np
import sklearn
from sklearn.feature_selection import chi2
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import balanced_accuracy_score, mutual_info_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.svm import SVC

CLASSES, COLUMNS = 4, 6


class Random:
    """A linear congruential generator that both sides have (Knuth's MMIX)."""

    def __init__(self, seed):
        self.state = seed

    def uniform(self):
        """A multiple of 2^-24 in [0, 1)."""
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (self.state >> 40) / 2**24


def samples(seed, count):
    """Class min(i² mod 7, 3) of sample i: uneven numbers; values in [0, 2), float32."""
    random = Random(seed)
    centers = Random(99)
    centers = [[centers.uniform() for _ in range(COLUMNS)] for _ in range(CLASSES)]
    classes = [min(i * i % 7, 3) for i in range(count)]
    rows = [[centers[c][k] + random.uniform() for k in range(COLUMNS)] for c in classes]
    return np.array(rows, dtype=np.float32).astype(np.float64), np.array(classes)


def numbers(matrix):
    return [[float(f"{v:.9g}") for v in row] for row in matrix]


x, y = samples(1, 160)
queries, truth = samples(2, 40)
result = {"sklearn": sklearn.__version__}
for name, balanced in (("svm", None), ("svm_balanced", "balanced")):
    svm = SVC(C=3, gamma=0.7, class_weight=balanced, decision_function_shape="ovo", tol=1e-5).fit(x, y)
    result[name] = numbers(svm.decision_function(queries))
result["linear_svm"] = numbers(SVC(C=3, kernel="linear", decision_function_shape="ovo", tol=1e-5).fit(x, y).decision_function(queries))
result["logistic"] = numbers(LogisticRegression(C=10, solver="liblinear", tol=1e-6, max_iter=1000).fit(x, y).predict_proba(queries))
result["knn"] = numbers(KNeighborsClassifier(7, weights="distance").fit(x, y).predict_proba(queries))
result["chi2"] = numbers([chi2(x, y)[0]])[0]


def bins(column):
    """Eight bins of equally many values; equal values share the bin of the first."""
    rank = np.searchsorted(np.sort(column), column, side="left")
    return rank * 8 // len(column)


coarse = np.floor(x * 4) / 4
result["mutual_information"] = numbers([[mutual_info_score(bins(coarse[:, k]), y) for k in range(COLUMNS)]])[0]
guesses = (truth + (np.arange(len(truth)) % 3 == 0)) % CLASSES
result["balanced_accuracy"] = balanced_accuracy_score(truth, guesses)
print(json.dumps(result, separators=(",", ":")).replace("],[", "],\n["))
