# SPDX-License-Identifier: Apache-2.0
"""Types that the modules share. Private."""

from __future__ import annotations

import os
from typing import Callable, Union

import numpy as np
import numpy.typing as npt

Path = Union[str, "os.PathLike[str]"]
"""Where files are."""
Progress = Union[bool, Callable[[str, int, int], None], None]
"""How far long work is: a function of (what, done, total), which may raise to stop; True: a line on stderr."""
Image = npt.NDArray[np.uint8]
"""(height, width, 3), BGR."""
Depth = npt.NDArray[np.float32]
"""(height, width), along the optical axis [m], 0 where unknown."""
FloatArray = npt.NDArray[np.float32]


def progress_callback(progress: Progress) -> bool | Callable[[str, int, int], None] | None:
    """As the extension takes it."""
    return progress or None
