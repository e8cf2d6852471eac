"""Context of the lint checks."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import Any

from rtgen.compiler.model import (
    Case,
    Declaration,
    ExceptionDecl,
    Member,
    Model,
    SourceFile,
    Struct,
    Union,
)

_NO_CODE = re.compile(
    r"//[^\n]*|/\*.*?(?:\*/|\Z)|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL
)
_WORD = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True, eq=False)
class Context:
    """The model, source texts by displayed path, options of plug-ins, and the target."""

    model: Model
    sources: Mapping[str, str]
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    target: str = ""

    @cached_property
    def files(self) -> dict[str, SourceFile]:
        """The files by their displayed paths."""
        return {file.name: file for file in self.model.files}

    @cached_property
    def declarations(self) -> list[Declaration]:
        """The declarations of the given files."""
        return [d for d in self.model.declarations if self.is_given(d.file)]

    def is_given(self, name: str) -> bool:
        """Return whether a file was given (not only included), or is part of one that was."""
        file = self.files.get(name)
        return file is not None and (
            file.main
            or (file.belongs_to is not None and self.is_given(file.belongs_to))
        )

    @cached_property
    def words(self) -> dict[str, list[str]]:
        """The identifiers of each file, including directives, without comments and strings."""
        return {
            name: _WORD.findall(_NO_CODE.sub(" ", text))
            for name, text in self.sources.items()
        }

    @cached_property
    def count(self) -> Counter[str]:
        """How often each identifier occurs in all files."""
        return Counter(chain.from_iterable(self.words.values()))


def fields(declaration: Declaration) -> Iterator[Member | Case]:
    """Yield the members of a struct or exception, or the branches of a union."""
    match declaration:
        case Struct(members=members) | ExceptionDecl(members=members):
            yield from members
        case Union(cases=cases):
            yield from cases
