"""Determines the Python type of numeric sequences and arrays: `[python] numeric`, `@numeric`.

The result is stored in the types of members, branches and typedefs. Types elsewhere, such as those
of parameters, are lists unless they are named.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import prod
from typing import Any, Final, TypeVar, cast

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.lowering.numeric_rules import NO_NUMBERS
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import (
    ArrayType,
    Case,
    Declaration,
    ExceptionDecl,
    Extensibility,
    MapType,
    Member,
    Model,
    NamedType,
    PrimitiveType,
    SequenceType,
    Struct,
    Type,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
)
from rtgen.facts.numeric import MAX_LIST_LENGTH, Numeric
from rtgen.facts.primitives import NUMBERS, OCTET_TYPES

_E = TypeVar("_E", bound=Member | Case | Typedef | ValueBox)

_ENTRIES: Final = {
    Struct: "members",
    ExceptionDecl: "members",
    Union: "cases",
    Valuetype: "state",
}


def lower(model: Model, settings: Settings) -> Lowered:
    """Return the model with a form for each sequence and array, and diagnostics of `@numeric`."""
    forms = _Forms(model, settings)
    declarations = tuple(map(forms.declaration, model.declarations))
    if any(a is not b for a, b in zip(declarations, model.declarations, strict=True)):
        model = replace(model, declarations=declarations)
    return Lowered(model, tuple(forms.findings))


class _Forms:
    def __init__(self, model: Model, settings: Settings) -> None:
        self._model = model
        self._default = settings.numeric
        self._final = settings.extensibility == Extensibility.FINAL
        self.findings: list[Diagnostic] = []

    def declaration(self, declaration: Declaration) -> Declaration:
        """Return the declaration with the forms of its members; unchanged if all are lists."""
        if isinstance(declaration, Typedef | ValueBox):
            return self._entry(declaration)
        attribute = _ENTRIES.get(type(declaration))
        if attribute is None:
            return declaration
        before = getattr(declaration, attribute)
        entries = tuple(map(self._entry, before))
        if all(a is b for a, b in zip(entries, before, strict=True)):
            return declaration
        return replace(declaration, **cast("Any", {attribute: entries}))

    def _entry(self, entry: _E) -> _E:
        """Return a member, a branch, a typedef or a boxed value."""
        form: Numeric | None = None
        type_ = entry.type
        annotation = entry.annotation("numeric")
        if annotation is not None:
            form = cast("Numeric", str(annotation.get()).lower())
            type_ = self._model.unalias(type_)
            if not self._can_be(type_, form):
                message = f"`{entry.type}` cannot be {form} in Python"
                hint = "@numeric belongs to sequences and arrays of numbers"
                self.findings.append(NO_NUMBERS.at(entry.span, message, hint=hint))
                return entry
        formed = self._with_form(type_, form)
        return entry if formed is entry.type else replace(entry, type=formed)

    def _with_form(self, type_: Type, chosen: Numeric | None) -> Type:
        """Return the type with a form: `chosen`, or else that of the project."""
        match type_:
            case MapType(value=value):
                inner = self._with_form(value, None)
                return type_ if inner is value else replace(type_, value=inner)
            case SequenceType(element) | ArrayType(element):
                form = chosen or self._project_form(type_)
                inner = self._with_form(element, None)
                if inner is element and form == "list":
                    return type_
                return replace(type_, element=inner, numeric=form)
        return type_

    def _project_form(self, type_: SequenceType | ArrayType) -> Numeric:
        """Return the form of the project, if the type can have it and it pays off."""
        if not self._can_be(type_, self._default):
            return "list"
        if self._default == "array":
            bound = type_.bound if isinstance(type_, SequenceType) else _count(type_)
            if bound is not None and bound <= MAX_LIST_LENGTH:
                return "list"
        return self._default

    def _can_be(self, type_: Type, form: Numeric) -> bool:
        """Return whether values of the type can have the form."""
        if not isinstance(type_, SequenceType | ArrayType):
            return False
        element = self._model.unalias(type_.element)
        if _is_number(element):
            flat = isinstance(type_, SequenceType) or len(type_.dimensions) == 1
            return flat or form != "array"
        if form != "numpy" or not isinstance(type_, SequenceType):
            return form == "list"
        return isinstance(element, NamedType) and self._is_record(element)

    def _is_record(self, type_: Type) -> bool:
        """Return whether values are structs of numbers, all with the same layout in a sequence."""
        aligns = list(self._alignments(type_, 0))
        return bool(aligns) and min(aligns) > 0 and aligns[0] == max(aligns)

    def _alignments(self, type_: Type, depth: int) -> Iterator[int]:
        """Yield the alignment of each number in order; 0 for anything else."""
        type_ = self._model.unalias(type_)
        match type_:
            case PrimitiveType(kind) if kind in NUMBERS:
                yield NUMBERS[kind].align
                return
            case ArrayType(element):
                inner = self._model.unalias(element)
                flat = len(type_.dimensions) == 1
                if _is_number(inner) or (flat and _is_octet(inner)):
                    assert isinstance(inner, PrimitiveType)
                    yield NUMBERS[inner.kind].align
                    return
            case NamedType(name):
                struct = self._model.find(name)
                if isinstance(struct, Struct) and depth < _MAX_DEPTH:
                    members = self._model.members(struct)
                    if not self._is_final(struct) or any(m.optional for m in members):
                        yield 0
                    for member in members:
                        yield from self._alignments(member.type, depth + 1)
                    return
        yield 0

    def _is_final(self, struct: Struct) -> bool:
        written = any(a.name in ("final", "extensibility") for a in struct.annotations)
        return struct.extensibility is Extensibility.FINAL and (self._final or written)


_MAX_DEPTH: Final = 32
"""Maximum nesting of structs that is examined."""


def _is_number(type_: Type) -> bool:
    if not isinstance(type_, PrimitiveType):
        return False
    return type_.kind in NUMBERS and type_.kind not in OCTET_TYPES


def _is_octet(type_: Type) -> bool:
    return isinstance(type_, PrimitiveType) and type_.kind in OCTET_TYPES


def _count(type_: ArrayType) -> int:
    return prod(type_.dimensions)
