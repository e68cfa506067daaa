# SPDX-License-Identifier: Apache-2.0
# The extension is private: the typed modules of the package check and cast what it gives.
from typing import Any

__version__: str

def __getattr__(name: str) -> Any: ...
