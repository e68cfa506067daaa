# SPDX-License-Identifier: Apache-2.0
"""The areas of a run, named by their words.

04_zones.py SEQUENCE
"""

import sys

import estancia

labels = estancia.load_model("inception-v3").label_sequence(estancia.open_sequence(sys.argv[1]))
zones = estancia.find_zones(labels)
print(f"{len(zones)} zones: {zones.cut_reason}")
for zone in zones:
    print(f"zone {zone.id}: {len(zone.images)} images, {zone.name}")
