# SPDX-License-Identifier: Apache-2.0
"""Words: which labels a person means by words of her own, and words that people use for labels."""

from __future__ import annotations

from typing import Sequence as SequenceOf, cast

import numpy.typing as npt

from . import _estancia
from .labels import LabelProbability
from .maps import LabelMatch

__all__ = ["common_rooms", "familiar_words", "find_name", "search_labels", "wordnet_hint"]


def search_labels(labels: SequenceOf[str], words: str) -> list[LabelMatch]:
    """Labels that the words mean, most probable first, with the reason; by their names alone without WordNet.

    >>> estancia.search_labels(labeler.labels, "coffee")[0].label
    'espresso maker'
    """
    return cast("list[LabelMatch]", _estancia.search_labels(list(labels), words))


def familiar_words(labels: SequenceOf[str], probabilities: npt.ArrayLike, count: int = 5) -> list[LabelProbability]:
    """What is likely, in words that people use: "dog" for five breeds."""
    return cast("list[LabelProbability]", _estancia.familiar_words(list(labels), probabilities, count))


def find_name(names: SequenceOf[str], words: str) -> str | None:
    """The name that the words surely mean: other spelling, plural, synonym; None where that is not sure."""
    return cast("str | None", _estancia.find_name(list(names), words))


def common_rooms() -> list[str]:
    """Rooms that are tried where nobody says which there are."""
    return cast("list[str]", _estancia.common_rooms())


def wordnet_hint() -> str:
    """What to install so that words are understood; "" when WordNet is there."""
    return cast(str, _estancia.wordnet_hint())
