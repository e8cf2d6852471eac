"""The text of compiled codecs, as debuggers and tracebacks show it (golden files)."""

from __future__ import annotations

import linecache
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.runtime.marshalling.compiler import compiled_in_python
from rtgen.runtime.marshalling.layouts.formats import CLASSIC, Format
from rtgen.runtime.marshalling.source.text import entered

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
            file = compiled_in_python(kind, descriptor, format_).__code__.co_filename
            yield f"# {format_} {kind} of {descriptor.name}\n"
            yield "".join(linecache.getlines(file)) + "\n"


@pytest.mark.parametrize("format_", PRINTED, ids=str)
def test_golden(package: Any, format_: Format, update_golden: bool) -> None:
    text = "\n".join(text_of(package, format_))
    path = GOLDEN / f"{format_}.txt"
    if update_golden:
        path.write_text(text, encoding="utf-8")
    assert text == path.read_text(encoding="utf-8")


def test_the_text_of_a_type_that_is_compiled_again_is_kept_once(package: Any) -> None:
    descriptor = package.Place._descriptor_
    files = set()
    for _ in range(3):
        descriptor.codecs.clear()
        function = compiled_in_python("from_cdr", descriptor, CLASSIC)
        files.add(function.__code__.co_filename)
    assert len(files) == 1


def test_different_texts_of_one_name_are_kept_beside_each_other() -> None:
    texts = ("a = 1\n", "a = 2\n", "a = 2\n\n", "a = 1\n")
    files = [entered(text, "<a test>") for text in texts]
    assert [linecache.getlines(file) for file in files] == [
        text.splitlines(keepends=True) for text in texts
    ]
    assert files == ["<a test>", "<a test 2>", "<a test 3>", "<a test>"]
