"""`__tool_info__( "tecsgen" ) { ... }`: what a file of the editor tecscde needs to be read.

tecsgen imports its `direct_import` before anything else, looks in the folders of `import_path`, and
gives the macros of `define_macro` to C headers. Other tools' information has no meaning for it.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

from rtgen.frontends.cdl.text.source import Source

_HEAD = re.compile(r'__tool_info__\s*\(\s*"tecsgen"\s*\)\s*(?={)')


@dataclass(frozen=True, slots=True)
class ToolInformation:
    """What a file says to tecsgen; `start` and `end` are its place."""

    start: int
    end: int
    imports: tuple[str, ...]
    folders: tuple[str, ...]
    macros: tuple[str, ...]


def tool_information(source: Source) -> ToolInformation | None:
    """The information for tecsgen in a file; what is no JSON is left to the parser."""
    found = _HEAD.search(source.code)
    if found is None:
        return None
    try:
        values, end = json.JSONDecoder().raw_decode(source.code, found.end())
    except (ValueError, RecursionError):
        return None
    return ToolInformation(
        found.start(),
        end,
        _texts(values.get("direct_import")),
        _texts(values.get("import_path")),
        _texts(values.get("define_macro")),
    )


def _texts(value: object) -> tuple[str, ...]:
    items = value if isinstance(value, list) else ()
    return tuple(item for item in items if isinstance(item, str))
