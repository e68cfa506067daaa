# SPDX-License-Identifier: Apache-2.0
"""Errors: everything that the package raises by itself, each with a stable code beside the sentence.

An interrupted call raises :class:`KeyboardInterrupt`, and what a callback raises comes through as it is.
"""

from __future__ import annotations


class Error(Exception):
    """Base of all errors. The message says what is wrong, where, and what to do."""

    def __init__(self, sentence: str, code: str = "invalid-state") -> None:
        super().__init__(sentence)
        self.code = code
        """The stable name of the kind of failure, ``"file-not-found"``; see docs/reference/errors.md."""

    def __reduce__(self) -> tuple[type[Error], tuple[str, str]]:
        return type(self), (str(self), self.code)


class InvalidInputError(Error, ValueError):
    """An option, a name or data that cannot be used: ``invalid-option``, ``unknown-name``, ``invalid-input``,
    ``mismatch``, ``insufficient-data``, ``too-large``."""


class FileError(Error, OSError):
    """A file that cannot be read or written: the codes ``file-…``, ``malformed-file``, ``truncated-file``,
    ``corrupt-file``, ``unsupported-file`` and ``unsafe-path``."""

    def __str__(self) -> str:
        return str(self.args[0])


class MissingFileError(FileError, FileNotFoundError):
    """There is no file or folder of that name."""


class ExistingFileError(FileError, FileExistsError):
    """A file is in the way and may not be replaced."""


class NoAnswerError(Error, LookupError):
    """A sound question that has no answer: nothing has that name, no route leads there."""


class InterruptedWorkError(Error):
    """Long work was asked to stop in a thread that cannot raise KeyboardInterrupt; what was done is kept."""


_CLASSES: dict[str, type[Error]] = {
    **dict.fromkeys(
        ("invalid-option", "unknown-name", "invalid-input", "mismatch", "insufficient-data", "too-large"),
        InvalidInputError,
    ),
    **dict.fromkeys(
        (
            "file-unreadable",
            "file-unwritable",
            "malformed-file",
            "truncated-file",
            "corrupt-file",
            "unsupported-file",
            "unsafe-path",
        ),
        FileError,
    ),
    "file-not-found": MissingFileError,
    "file-exists": ExistingFileError,
    "no-answer": NoAnswerError,
    "interrupted": InterruptedWorkError,
}


def _error_of(code: str, sentence: str) -> Error:
    """The exception of a code; called by the extension."""
    return _CLASSES.get(code, Error)(sentence, code)
