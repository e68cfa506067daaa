# SPDX-License-Identifier: Apache-2.0
"""Any function labels images: here one that only sees how bright they are.

03_your_own_labeler.py SEQUENCE MAP.estancia
"""

import sys
from typing import Any

import numpy as np
import numpy.typing as npt

import estancia


def look(image: npt.NDArray[Any]) -> dict[str, float]:
    light = float(np.mean(image)) / 255
    return {"bright": light, "dark": 1 - light}


with estancia.MappingSession(sys.argv[2], estancia.CallableLabeler(look, ["bright", "dark"])) as session:
    for image in estancia.open_sequence(sys.argv[1]).images():
        session.add(image)
    print(session.map())
