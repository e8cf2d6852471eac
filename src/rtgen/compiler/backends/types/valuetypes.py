"""Valuetypes and boxed values: classes whose codec interprets their descriptor."""

from __future__ import annotations

import msgspec

from rtgen.compiler.backends.kit.member_texts import member_text, operation_text
from rtgen.compiler.backends.kit.python_initial import PythonInitial
from rtgen.compiler.backends.kit.quoting.python import docstring, string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.backends.types.descriptions import (
    Descriptions,
    attribute_text,
    signature,
)
from rtgen.compiler.backends.types.interfaces import Interfaces
from rtgen.compiler.backends.types.scope import Scope
from rtgen.compiler.model import InitialValue, Type, ValueBox, Valuetype
from rtgen.compiler.typemap.python.idl import PythonMapping
from rtgen.compiler.typemap.python.idl_names import PythonNames


class _Method(msgspec.Struct, frozen=True):
    name: str
    parameters: str
    result: str
    docstring: str
    message: str


class _Property(msgspec.Struct, frozen=True):
    name: str
    type: str
    docstring: str
    readonly: bool
    message: str


class Statement(msgspec.Struct, frozen=True):
    """A statement in a class body, with its docstring."""

    text: str
    docstring: str


class Valuetypes(msgspec.Struct, eq=False):
    """Writes valuetypes into one module."""

    _names: PythonNames
    _py: Scope
    _mapping: PythonMapping
    _describe: Descriptions
    _interfaces: Interfaces
    initial: PythonInitial
    _fields: dict[tuple[Type, InitialValue | None, bool], str] = {}

    def text(self, declaration: Valuetype, nested: list[str]) -> str:
        """Return the class of a valuetype: its state as fields, its operations for the user."""
        py = self._py
        names = self._names.members(declaration)
        called = self._names.operations(declaration)
        mapping = self._interfaces.mapping
        methods = [
            _Method(
                name=called[o.name],
                parameters=", ".join(mapping.parameters(o)),
                result=mapping.result(o),
                docstring=docstring(operation_text(o), 8, f"`{signature(o)}`."),
                message=string_literal(f"{declaration.scoped}::{o.name}"),
            )
            for o in declaration.operations
        ]
        properties = [
            _Property(
                name=called[a.name],
                type=mapping.annotation(a.type),
                docstring=docstring(member_text(a, text), 8, text),
                readonly=a.readonly,
                message=string_literal(f"{declaration.scoped}::{a.name}"),
            )
            for a in declaration.attributes
            for text in (f"`{attribute_text(a)}`.",)
        ]
        bases = [py.reference(base) for base in self._names.bases(declaration)]
        return render(
            "types/valuetype.py.j2",
            py=py,
            decorator=f"{py.dataclass}(eq=False, slots=True)",
            name=py.reference(declaration.name),
            bases=", ".join(bases or [py.Value]),
            docstring=docstring(declaration.doc, 4, f"`{declaration.scoped}`."),
            descriptor=self._describe.value(declaration),
            nested=nested,
            fields=[
                Statement(
                    f"{names[m.name]}: {self.field(m.type, m.initial)}",
                    docstring(member_text(m), 4),
                )
                for m in declaration.state
            ],
            methods=methods,
            properties=properties,
        )

    def box(self, declaration: ValueBox) -> str:
        """Return the class of a boxed value."""
        py = self._py
        return render(
            "types/valuetype.py.j2",
            py=py,
            decorator=f"{py.dataclass}(eq=False, slots=True)",
            name=py.reference(declaration.name),
            bases=py.Box,
            docstring=docstring(declaration.doc, 4, f"`{declaration.scoped}`."),
            descriptor=self._describe.box(declaration),
            nested=[],
            fields=[Statement(f"value: {self.field(declaration.type)}", "")],
            methods=[],
            properties=[],
        )

    def field(
        self, type_: Type, own: InitialValue | None = None, dataclass: bool = True
    ) -> str:
        """Return annotation and initial value of a field of a `dataclass` or a `msgspec.Struct`.

        `own` is the default of the member.
        """
        key = type_, own, dataclass
        field_text = self._fields.get(key)
        if field_text is None:
            field_text = self._fields[key] = self._field(*key)
        return field_text

    def _field(self, type_: Type, own: InitialValue | None, dataclass: bool) -> str:
        annotation = self._mapping.annotation(type_)
        if self._mapping.immutable(type_):
            return f"{annotation} = {self.initial.expression(type_, own)}"
        factory = self.initial.factory(type_, own)
        field = self._py.dataclass_field if dataclass else self._py.field
        return f"{annotation} = {field}(default_factory={factory})"
