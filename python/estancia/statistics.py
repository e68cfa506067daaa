# SPDX-License-Identifier: Apache-2.0
"""Statistics: rank tests of methods, agreement of clusters with classes, distances and dendrograms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Mapping, Sequence as SequenceOf, cast

import numpy as np
import numpy.typing as npt

from . import _estancia
from ._common import Progress, progress_callback

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .options import ComparisonOptions

__all__ = [
    "Agreement",
    "FriedmanTest",
    "MethodComparison",
    "MethodRank",
    "WilcoxonTest",
    "compare_methods",
    "critical_difference",
    "distances",
    "friedman_test",
    "holm_adjusted",
    "linkage",
    "linkages",
    "mean_ranks",
    "measure_agreement",
    "pairwise_distances",
    "shaffer_adjusted",
    "wilcoxon_test",
]


@dataclass(frozen=True)
class FriedmanTest:
    """Friedman's test of the hypothesis that all methods are equivalent."""

    chi_squared: float
    degrees: int
    p: float
    f: float
    """Of Iman and Davenport, less conservative."""
    f_p: float
    undefined: str
    """Why there is nothing to test; "" otherwise."""


@dataclass(frozen=True)
class WilcoxonTest:
    """Wilcoxon's signed-rank test of two methods."""

    better: float
    worse: float
    different: int
    exact: bool
    z: float
    p: float
    """Two-sided."""


@dataclass(frozen=True)
class MethodRank:
    """One method beside the control."""

    method: str
    mean_rank: float
    p: float | None
    """Adjusted, against the control; None for the control itself."""
    rejected: bool
    """Whether it differs significantly from the control."""
    wins: int
    """Tests where the control is better."""
    ties: int
    losses: int


@dataclass(frozen=True)
class MethodComparison:
    """Friedman's test and a post-hoc test."""

    friedman: FriedmanTest
    differ: bool
    control: str
    methods: list[MethodRank]
    """The best mean rank first."""
    critical_difference: float | None
    """Nemenyi's."""


def _table(scores: npt.ArrayLike) -> list[list[float]]:
    return cast("list[list[float]]", np.asarray(scores, dtype=np.float64).tolist())


def mean_ranks(scores: npt.ArrayLike, *, larger_is_better: bool = True) -> list[float]:
    """The mean rank of each method from 1; ``scores``: tests × methods. Raises InvalidInputError."""
    return cast("list[float]", _estancia.mean_ranks(_table(scores), larger_is_better))


def friedman_test(scores: npt.ArrayLike) -> FriedmanTest:
    """``scores``: tests × methods. As SciPy's friedmanchisquare, with the statistic of Iman and Davenport."""
    return cast(FriedmanTest, _estancia.friedman_test(_table(scores)))


def wilcoxon_test(a: npt.ArrayLike, b: npt.ArrayLike) -> WilcoxonTest:
    """The scores of two methods in each test. As SciPy's wilcoxon, zero_method "wilcox", without correction."""
    return cast(WilcoxonTest, _estancia.wilcoxon_test(np.asarray(a).tolist(), np.asarray(b).tolist()))


def holm_adjusted(p: npt.ArrayLike) -> list[float]:
    """Holm's adjustment of p-values, in their order."""
    return cast("list[float]", _estancia.holm_adjusted(np.asarray(p, dtype=np.float64).tolist()))


def shaffer_adjusted(p: npt.ArrayLike, methods: int) -> list[float]:
    """Shaffer's static adjustment of the p-values of all pairs of ``methods`` methods."""
    return cast("list[float]", _estancia.shaffer_adjusted(np.asarray(p, dtype=np.float64).tolist(), methods))


def critical_difference(alpha: float, methods: int, tests: int) -> float:
    """Of two mean ranks, by Nemenyi's test."""
    return cast(float, _estancia.critical_difference(alpha, methods, tests))


def compare_methods(
    scores: Mapping[str, SequenceOf[float]],
    tests: SequenceOf[str] | None = None,
    **options: Unpack[ComparisonOptions],
) -> MethodComparison:
    """Which of several methods differ significantly? ``scores``: of each method, one a test. Options:
    :class:`estancia.options.ComparisonOptions`.

    >>> estancia.compare_methods({"gist": [.61, .58, .70], "cnn": [.83, .80, .85]}, post_hoc="holm")
    """
    methods = list(scores)
    rows = np.array([list(scores[method]) for method in methods], dtype=np.float64).T
    names = list(tests) if tests is not None else [f"test {i + 1}" for i in range(len(rows))]
    return cast(MethodComparison, _estancia.compare_methods(methods, names, rows.tolist(), dict(options)))


@dataclass(frozen=True)
class Agreement:
    """How well clusters agree with classes; larger is better."""

    homogeneity: float
    completeness: float
    v_measure: float
    adjusted_rand_index: float
    purity: float


def measure_agreement(truth: npt.ArrayLike, clusters: npt.ArrayLike) -> Agreement:
    """Compares two labelings of the same items, whole numbers."""
    return cast(Agreement, _estancia.measure_agreement(np.asarray(truth).tolist(), np.asarray(clusters).tolist()))


def pairwise_distances(
    descriptors: npt.ArrayLike, distance: str = "hellinger", *, progress: Progress = False
) -> npt.NDArray[np.float64]:
    """Distances of all pairs of rows, condensed as SciPy's pdist gives them; ``distance``: one of
    :func:`distances`."""
    found = _estancia.pairwise_distances(descriptors, distance, progress_callback(progress))
    return cast("npt.NDArray[np.float64]", found)


def linkage(condensed: npt.ArrayLike, items: int, method: str = "average") -> npt.NDArray[np.float64]:
    """Hierarchical clustering, as SciPy's linkage gives it: (items - 1) × 4; ``method``: one of :func:`linkages`."""
    return cast("npt.NDArray[np.float64]", _estancia.linkage(condensed, items, method))


def distances() -> dict[str, str]:
    """The names of distances of descriptors, with what each is."""
    return dict(_estancia.distances())


def linkages() -> dict[str, str]:
    """The names of linkages, with what each is."""
    return dict(_estancia.linkages())
