# SPDX-License-Identifier: Apache-2.0
"""An image becomes words: its most probable labels.

02_label_an_image.py IMAGE [MODEL]
"""

import sys

import estancia

labeler = estancia.load_model(*sys.argv[2:3])
for label in labeler.best(estancia.read_image(sys.argv[1]), 10):
    print(f"{label.probability:6.1%}  {label.label}")
