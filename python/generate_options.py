#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes python/estancia/options.py, the typed options of the package, from what the library declares.

PYTHONPATH=build/python python3 python/generate_options.py > python/estancia/options.py; a test says when it is due.
"""

from __future__ import annotations

import sys
import textwrap
from typing import Any

HEADER = '''# SPDX-License-Identifier: Apache-2.0
"""Options: the keyword arguments of the package's functions. Each is declared once, in the library, which checks it.

Made by python/generate_options.py. A group inside is a dict:
``scene_filter={"method": "gng", "points": 5000}``.
"""

from __future__ import annotations

from typing import Literal, TypedDict, Union

__all__ = [
'''
TEXT = '''Text = Union[str, "os.PathLike[str]", "list[str]"]
"""A text, a path, or a list that becomes one with commas."""'''


def class_name(parent: str, key: str) -> str:
    return parent.removesuffix("Options") + "".join(part.capitalize() for part in key.split("_")) + "Options"


def type_of(option: dict[str, Any]) -> str:
    names = option["choices"]
    if names and option["type"] == "str":
        return f"Literal[{', '.join(repr(name).replace(chr(39), chr(34)) for name in names)}]"
    return {"str": "Text"}.get(option["type"], option["type"])


def comment(option: dict[str, Any]) -> str:
    facts = [option["help"].strip()]
    if option["why"]:
        facts.append(option["why"].strip().rstrip(".") + ".")
    accepted = option["accepted"]
    facts.append(f"{accepted[:1].upper()}{accepted[1:]}; default: {option['default'] or 'not set'}.")
    return " ".join(facts).replace("\\", "\\\\")


def content(group: dict[str, Any]) -> str:
    return repr((group["options"], group["groups"]))


def declare(name: str, group: dict[str, Any], out: list[str], names: list[str], known: dict[str, str]) -> None:
    """Groups of the same options, with the same defaults, are one class."""
    inside = []
    for each in group["groups"]:
        inner = known.get(content(each))
        if inner is None:
            inner = known[content(each)] = class_name(name, each["key"])
            declare(inner, each, out, names, known)
        inside.append((each["key"], inner, each))
    names.append(name)
    lines = [f"class {name}(TypedDict, total=False):"]
    lines += docstring(group["help"].strip(), 4)
    for option in group["options"]:
        lines.append(f"    {option['key']}: {type_of(option)}")
        lines += docstring(comment(option), 4)
    for key, inner, each in inside:
        lines.append(f"    {key}: {inner}")
        lines += docstring(each["help"].strip(), 4)
    out.append("\n".join(line if len(line) <= 120 else fold(line) for line in lines))


def docstring(text: str, indent: int) -> list[str]:
    pad = " " * indent
    if len(text) + indent + 6 <= 120:
        return [f'{pad}"""{text}"""']
    lines = textwrap.wrap(text, 120 - indent - 3)
    return [f'{pad}"""{lines[0]}', *[pad + line for line in lines[1:-1]], f'{pad}{lines[-1]}"""']


def fold(line: str) -> str:
    head, body = line.split("Literal[", 1)
    return f"{head}Literal[\n" + "\n".join(f"        {name}," for name in body[:-1].split(", ")) + "\n    ]"


def text() -> str:
    from estancia import _estancia

    classes: list[str] = []
    names: list[str] = []
    groups = _estancia.options()
    known = {content(group): name for name, group in groups.items()}
    for name, group in groups.items():
        declare(name, group, classes, names, known)
    header = HEADER.replace("from typing import", "import os\nfrom typing import")
    return header + "".join(f'    "{name}",\n' for name in names) + "]\n\n" + TEXT + "\n\n\n" + "\n\n\n".join(classes) + "\n"


if __name__ == "__main__":
    sys.path.pop(0)  # the sources beside this file have no extension
    print(text(), end="")
