"""`__tool_info__( "tecsgen" ) { ... }`: tecsgen's settings in a file of the editor tecscde."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

from rtgen.compiler.frontends.cdl.text.source import Source

_HEAD = re.compile(r'__tool_info__\s*\(\s*"tecsgen"\s*\)\s*(?={)')


@dataclass(frozen=True, slots=True)
class ToolInformation:
    """The settings of tecsgen in a file; `start` and `end` are their offsets."""

    start: int
    end: int
    imports: tuple[str, ...]
    folders: tuple[str, ...]
    macros: tuple[str, ...]


def tool_information(source: Source) -> ToolInformation | None:
    """Return the settings of tecsgen in a file; text that is not JSON is left to the parser."""
    match = _HEAD.search(source.code)
    if match is None:
        return None
    try:
        values, end = json.JSONDecoder().raw_decode(source.code, match.end())
    except (ValueError, RecursionError):
        return None
    return ToolInformation(
        match.start(),
        end,
        _texts(values.get("direct_import")),
        _texts(values.get("import_path")),
        _texts(values.get("define_macro")),
    )


def _texts(value: object) -> tuple[str, ...]:
    items = value if isinstance(value, list) else ()
    return tuple(item for item in items if isinstance(item, str))
