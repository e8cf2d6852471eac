"""Back end for adapters: generates their modules."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from msgspec.structs import replace

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.backends.components.imports import Imports
from rtgen.compiler.backends.components.locations import base_location, source_of
from rtgen.compiler.backends.kit.python_module import PythonModule, python_module
from rtgen.compiler.backends.kit.quoting.python import number_literal, string_literal
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.kit.words import words
from rtgen.compiler.model import (
    Adapter,
    ArrayType,
    Component,
    Member,
    Model,
    NamedType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
)
from rtgen.compiler.typemap.constant_shapes import shape_of
from rtgen.compiler.typemap.python.idl_names import PythonNames
from rtgen.compiler.typemap.python.names import module_name
from rtgen.facts.adapter_constants import AdapterConstant, is_octets
from rtgen.facts.numeric import Numeric

_Scale: TypeAlias = Sequence[float]
"""Factor and offset of a conversion."""

_TAKEN = words("annotations bytes list made sample self Adapter")
"""The names that the template binds or uses."""


class AdaptersBackend:
    """Generates a module for each adapter."""

    name = "adapters"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return the modules of all adapters. The model has been checked."""
        return Emission(tuple(_artifacts(model, options)))


BACKEND = AdaptersBackend()


def _artifacts(model: Model, options: Options) -> Iterator[Artifact]:
    names = PythonNames(model, options.package)
    for number, adapter in enumerate(model.adapters):
        component = model.find((adapter.name,))
        assert isinstance(component, Component)
        source = source_of(model, component)
        origin = [source.key]
        if number == 0:
            yield python_module(
                f"{options.folder}/adapters/__init__.py",
                options,
                origin,
                "Adapters between data types.",
                plain=True,
            )
        yield _module(model, names, adapter, component, options, origin)


def _module(
    model: Model,
    names: PythonNames,
    adapter: Adapter,
    component: Component,
    options: Options,
    origin: Sequence[str],
) -> PythonModule:
    taken = {adapter.name, f"{adapter.name}Base", *_TAKEN, adapter.conversion}
    types = Imports(model, names, taken)
    copying = _Copies(model, names, types, adapter)
    body = render(
        "adapters/adapter.py.j2",
        name=adapter.name,
        location=base_location(options.package, component),
        doc=_doc(adapter),
        source=types.type_name(adapter.source),
        target=types.type_name(adapter.target),
        copies=[*copying.values()],
        conversion=adapter.conversion,
        stamps=adapter.stamps,
        constants=[
            (_path(model, names, adapter.target, to), copying.constant(to, value))
            for to, value in adapter.constants
        ],
    )
    return python_module(
        f"{options.folder}/adapters/{module_name(adapter.name)}.py",
        options,
        origin,
        f"{adapter.name}: {_doc(adapter)}",
        imports=types.imports(),
        body=body,
    )


@dataclass(frozen=True, slots=True)
class _Copies:
    """The copied members of an adapter, in the units and the forms of the target."""

    model: Model
    names: PythonNames
    types: Imports
    adapter: Adapter

    def values(self) -> Iterator[tuple[str, str]]:
        """Yield each copied member of the target, with the expression of its value."""
        adapter = self.adapter
        scales = {to: scale for to, *scale in adapter.scales}
        for to, source in adapter.copies:
            value = f"sample.{_path(self.model, self.names, adapter.source, source)}"
            *_, (_, theirs) = _members(self.model, adapter.source, source)
            *_, (_, own) = _members(self.model, adapter.target, to)
            types = self.model.unalias(theirs.type), self.model.unalias(own.type)
            path = string_literal(".".join((adapter.target[-1], *to)))
            text = self._converted(value, *types, path, scales.get(to))
            if own.optional and text != value:
                text = f"None if {value} is None else {text}"
            yield _path(self.model, self.names, adapter.target, to), text

    def constant(self, to: tuple[str, ...], value: AdapterConstant) -> str:
        """Return the expression of a constant for a member of the target."""
        text = _literal(value)
        *_, (_, member) = _members(self.model, self.adapter.target, to)
        type_ = self.model.unalias(member.type)
        if not isinstance(type_, SequenceType | ArrayType):
            return text
        if is_octets(shape_of(self.model, type_)):
            return f"bytes({text})"
        if type_.numeric == "numpy":
            path = string_literal(".".join((self.adapter.target[-1], *to)))
            return self._numbers(text, type_, path, ())
        return text

    def _converted(
        self, value: str, from_: Type, to: Type, path: str, scale: _Scale | None
    ) -> str:
        """Return the expression of a value of another unit or form."""
        theirs, own = _form(from_), _form(to)
        if theirs == own and scale is None:
            return value
        element = self.model.unalias(to.element) if isinstance(to, SequenceType) else to
        if isinstance(element, NamedType):
            class_ = self.types.type_name(element.name)
            if own == "numpy":
                return f"{self._function('to_records')}({value}, {class_}, {path})"
            return f"{self._function('to_structs')}({value}, {class_})"
        if theirs == "numpy" and own != "numpy":
            value = f"{self._function('to_list')}({value})"
        if scale is not None or own == "numpy":
            return self._numbers(value, to, path, scale or ())
        return f"list({value})" if (theirs, own) == ("array", "list") else value

    def _numbers(
        self, value: str, type_: Type, path: str, scale: _Scale, depth: int = 0
    ) -> str:
        """Return the expression of a converted number, or of a type's converted numbers."""
        if not isinstance(type_, SequenceType | ArrayType):
            return _scaled_number(value, *scale)
        if type_.numeric == "numpy":
            item = self.types.mapping.item(type_)
            numbers = scale if any(scale[1:]) else scale[:1]
            arguments = (value, item, path, *map(number_literal, numbers))
            return f"{self._function('to_numpy')}({', '.join(arguments)})"
        element = self.model.unalias(type_.element)
        if isinstance(type_, ArrayType) and len(type_.dimensions) > 1:
            element = replace(type_, dimensions=type_.dimensions[1:])
        each = f"each{depth or ''}"
        text = self._numbers(each, element, path, scale, depth + 1)
        return f"[{text} for {each} in {value}]"

    def _function(self, name: str) -> str:
        return self.types.spell("rtgen.runtime.forms", name)


def _form(type_: Type) -> Numeric:
    return type_.numeric if isinstance(type_, SequenceType | ArrayType) else "list"


def _scaled_number(value: str, factor: float, offset: float) -> str:
    text = value if factor == 1 else f"{number_literal(factor)} * {value}"
    if offset:
        text += f" {'-' if offset < 0 else '+'} {number_literal(abs(offset))}"
    return text


def _literal(value: AdapterConstant) -> str:
    if isinstance(value, str):
        return string_literal(value)
    if isinstance(value, tuple):
        return f"[{', '.join(map(_literal, value))}]"
    return number_literal(value)


def _doc(adapter: Adapter) -> str:
    return f"Makes {'::'.join(adapter.target)} of {'::'.join(adapter.source)}."


def _path(
    model: Model, names: PythonNames, struct: ScopedName, path: tuple[str, ...]
) -> str:
    """Return a path of members by their Python names."""
    return ".".join(
        names.members(declaration)[member.name]
        for declaration, member in _members(model, struct, path)
    )


def _members(
    model: Model, struct: ScopedName, path: tuple[str, ...]
) -> Iterator[tuple[Struct, Member]]:
    """Yield the members of a path, each with the struct that declares it."""
    declared = model.find(struct)
    assert isinstance(declared, Struct)
    name, *rest = path
    own = ((d, m) for d in model.lineage(declared) for m in d.members)
    declaration, member = next(pair for pair in own if pair[1].name == name)
    yield declaration, member
    if rest:
        type_ = model.unalias(member.type)
        assert isinstance(type_, NamedType)
        yield from _members(model, type_.name, tuple(rest))
