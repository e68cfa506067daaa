# SPDX-License-Identifier: Apache-2.0
"""Estancia: a mobile robot's maps in words.

Images become label probabilities; from these come topological maps that one can ask and drive, semantic zones, room
classifiers, objects that label themselves, and known objects in point clouds.

>>> import estancia
>>> home = estancia.map_sequence("drive/", "home.estancia")
>>> home.ask("coffee").places[0].node
3

Images are arrays of uint8, (height, width, 3), BGR, as in OpenCV; depth is float32 in meters. Long calls let other
threads run, hear Ctrl-C, and tell ``progress``. What a function takes beside its own parameters stands in
:mod:`estancia.options`.
"""

from __future__ import annotations

from . import _estancia, options
from .classify import *
from .classify import __all__ as _classify
from .clouds import *
from .clouds import __all__ as _clouds
from .drives import *
from .drives import __all__ as _drives
from .errors import (
    Error,
    ExistingFileError,
    FileError,
    InterruptedWorkError,
    InvalidInputError,
    MissingFileError,
    NoAnswerError,
)
from .geometry import *
from .geometry import __all__ as _geometry
from .labelers import *
from .labelers import __all__ as _labelers
from .labels import *
from .labels import __all__ as _labels
from .live import *
from .live import __all__ as _live
from .mapping import *
from .mapping import __all__ as _mapping
from .maps import *
from .maps import __all__ as _maps
from .objects import *
from .objects import __all__ as _objects
from .odometry import *
from .odometry import __all__ as _odometry
from .recognition import *
from .recognition import __all__ as _recognition
from .sequences import *
from .sequences import __all__ as _sequences
from .statistics import *
from .statistics import __all__ as _statistics
from .words import *
from .words import __all__ as _words
from .zones import *
from .zones import __all__ as _zones

__version__ = _estancia.__version__

__all__ = [
    "Error",
    "ExistingFileError",
    "FileError",
    "InterruptedWorkError",
    "InvalidInputError",
    "MissingFileError",
    "NoAnswerError",
    "options",
    *_classify,
    *_clouds,
    *_drives,
    *_geometry,
    *_labelers,
    *_labels,
    *_live,
    *_mapping,
    *_maps,
    *_objects,
    *_odometry,
    *_recognition,
    *_sequences,
    *_statistics,
    *_words,
    *_zones,
]
