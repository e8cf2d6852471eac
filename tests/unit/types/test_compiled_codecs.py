"""The text of compiled codecs, as debuggers and tracebacks show it (golden files)."""

from __future__ import annotations

import linecache
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.runtime.marshalling.compiler import compiled
from rtgen.runtime.marshalling.layouts.formats import CLASSIC, Format

GOLDEN = Path(__file__).parents[2] / "golden" / "codecs"
PRINTED = {
    CLASSIC: {"Place": "whole", "Many": "whole", "Choice": "part", "Holder": "whole"},
    Format(1): {"Perhaps": "whole", "Loose": "whole"},
    Format(2): dict.fromkeys(("Named", "Deep", "Perhaps", "Grown", "Loose"), "whole"),
}
"""The types that are printed in each format, as a whole value or as part of another one."""
KINDS = {"whole": ("to_cdr", "from_cdr"), "part": ("write", "read")}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("codecs")
    return emitted.emit(folder, [GOLDEN / "codecs.idl"]).c


def text_of(package: Any, format_: Format) -> Iterator[str]:
    for name, form in PRINTED[format_].items():
        descriptor = getattr(package, name)._descriptor_
        descriptor.codecs.clear()
        for kind in KINDS[form]:
            file = compiled(kind, descriptor, format_).__code__.co_filename
            yield f"# {format_} {kind} of {descriptor.name}\n"
            yield "".join(linecache.getlines(file)) + "\n"


@pytest.mark.parametrize("format_", PRINTED, ids=str)
def test_golden(package: Any, format_: Format, update_golden: bool) -> None:
    text = "\n".join(text_of(package, format_))
    path = GOLDEN / f"{format_}.txt"
    if update_golden:
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")
