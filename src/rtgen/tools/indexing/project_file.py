"""Names in rtgen.toml: types and members of adapters, files and folders of sources."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.frontends.kit.located_toml import Toml
from rtgen.compiler.kit.toml_text import TomlError
from rtgen.tools.indexing.idl import key_of
from rtgen.tools.indexing.index import Collector, Kind, path_of
from rtgen.tools.indexing.text import Text


def add_project_file(collector: Collector, file: str, text: Text) -> None:
    """Add the uses of types and files in the settings, displayed as `file`."""
    try:
        toml = Toml(text.normal, file)
    except TomlError:
        return  # reported when the project is loaded
    adapters = toml.content.get("adapter", {})
    for name, table in adapters.items() if isinstance(adapters, dict) else ():
        first, last = text.offsets(toml.span(("adapter", name)))
        begin = text.source.find(name, first, last)
        if begin >= 0:
            span = text.span(file, begin, begin + len(name))
            collector.define(key_of((name,)), name, Kind.COMPONENT, span)
        for end in ("from", "to"):
            written = table.get(end) if isinstance(table, dict) else None
            if isinstance(written, str):
                place = _value(text, toml, ("adapter", name, end), written)
                if place is not None:
                    parts = tuple(part for part in written.split("::") if part)
                    last = place[1] - len(parts[-1]) if parts else place[0]
                    collector.refer(key_of(parts), text.span(file, last, place[1]))
    sources = toml.content.get("sources", {})
    folder = Path(path_of(file)).parent
    for key in ("paths", "include"):
        paths = sources.get(key, ()) if isinstance(sources, dict) else ()
        for written in paths if isinstance(paths, list) else ():
            if isinstance(written, str) and (folder / written).is_file():
                place = _value(text, toml, ("sources", key), written)
                if place is not None:
                    target = path_of(str(folder / written))
                    collector.refer(f"file {target}", text.span(file, *place))


def _value(
    text: Text, toml: Toml, path: tuple[str, ...], written: str
) -> tuple[int, int] | None:
    """Return the place of a quoted text after a key."""
    start, _ = text.offsets(toml.span(path))
    for quote in "\"'":
        place = text.source.find(quote + written + quote, start)
        if place >= 0:
            return place + 1, place + 1 + len(written)
    return None
