# SPDX-License-Identifier: Apache-2.0
"""Writes scipy_rank_tests.json, what SciPy and mpmath say about inputs that test_scipy_rank_tests.cpp makes anew.

    PYTHONPATH=tests/stats python3 tests/stats/scipy_rank_tests.py > tests/stats/scipy_rank_tests.json
    (python3-scipy 1.10 and python3-mpmath 1.2 of Debian 12)
"""
import json
import warnings

import mpmath
import numpy as np
import scipy
from scipy.stats import friedmanchisquare, rankdata, studentized_range, wilcoxon

from scipy_random import Random


def scores(seed, tests, methods, steps, lead):
    """Multiples of 1/steps: few steps make ties. Method m leads by m * lead on average."""
    random = Random(seed)
    return np.array([[int((random.uniform() + m * lead) * steps) / steps for m in range(methods)] for _ in range(tests)])


def range_tail(q, groups):
    """P(range > q) of normal variables, with 60 digits."""
    mpmath.mp.dps = 60

    def integrand(z):
        a = mpmath.ncdf(z)
        return mpmath.npdf(z) * (a ** (groups - 1) - (a - mpmath.ncdf(z - q)) ** (groups - 1))

    return float(groups * mpmath.quad(integrand, mpmath.linspace(-16, 24, 41)))


def shaffer_hypotheses(methods):
    """How many hypotheses count at each step, by going through all ways to part the methods into equals."""

    def partitions(n, largest):
        if n == 0:
            yield []
        for part in range(min(n, largest), 0, -1):
            for rest in partitions(n - part, part):
                yield [part] + rest

    possible = {sum(n * (n - 1) // 2 for n in parts) for parts in partitions(methods, methods)}
    pairs = methods * (methods - 1) // 2
    return [max(s for s in possible if s <= pairs - i) for i in range(pairs)]


result = {"scipy": scipy.__version__, "mpmath": mpmath.__version__, "friedman": [], "wilcoxon": [], "range": []}
for seed, tests, methods, steps, lead in [
    (1, 25, 12, 1000, 0.02),
    (2, 10, 4, 1000, 0.1),
    (3, 8, 5, 4, 0.05),
    (4, 3, 3, 2, 0.0),
    (5, 200, 40, 100, 0.002),
]:
    table = scores(seed, tests, methods, steps, lead)
    found = friedmanchisquare(*table.T)
    result["friedman"].append(
        {
            "seed": seed,
            "tests": tests,
            "methods": methods,
            "steps": steps,
            "lead": lead,
            "mean_ranks": rankdata(-table, axis=1).mean(axis=0).tolist(),
            "statistic": found.statistic,
            "p": found.pvalue,
        }
    )
warnings.simplefilter("ignore")  # of few tests in the normal approximation
for seed, tests, steps, lead, mode in [
    (11, 5, 10**6, 0.2, "exact"),
    (12, 12, 10**6, 0.15, "exact"),
    (13, 50, 10**6, 0.1, "exact"),
    (14, 51, 10**6, 0.1, "approx"),
    (15, 30, 8, 0.1, "approx"),
    (16, 14, 4, -0.2, "approx"),
]:
    table = scores(seed, tests, 2, steps, lead)
    found = wilcoxon(table[:, 0], table[:, 1], mode=mode)
    result["wilcoxon"].append(
        {
            "seed": seed,
            "tests": tests,
            "steps": steps,
            "lead": lead,
            "exact": mode == "exact",
            "smaller_sum": found.statistic,
            "p": found.pvalue,
        }
    )
for groups in [2, 3, 5, 12, 40, 100, 500]:
    for q in [0.01, 0.5, 2, 3.3, 5, 8, 12, 16]:
        result["range"].append(
            {"groups": groups, "q": q, "scipy": studentized_range.sf(q, groups, np.inf), "mpmath": range_tail(q, groups)}
        )
result["shaffer"] = {str(k): shaffer_hypotheses(k) for k in [2, 3, 4, 5, 7, 12]}
print(json.dumps(result, separators=(",", ":")).replace("},{", "},\n{").replace('],"', '],\n"'))
