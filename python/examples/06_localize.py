# SPDX-License-Identifier: Apache-2.0
"""Finds the frames of another drive in a map.

06_localize.py MAP.estancia SEQUENCE
"""

import sys

import estancia

localizer = estancia.Localizer(sys.argv[1])
labeler = estancia.load_model(on_demand=True)
with labeler.stream(estancia.open_sequence(sys.argv[2])) as stream:
    for frame in stream:
        if not frame.problem:
            at = localizer.add(frame.probabilities)[0]
            print(f"frame {frame.index}: place {at.belief_node}, {at.confidence:.0%}")
