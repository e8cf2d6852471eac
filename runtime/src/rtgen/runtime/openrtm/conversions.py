"""Compiles conversions between values and omniORB's objects from descriptors, at first use.

Structs are filled field by field: a reused object, or a new one made without its constructor,
because calls of constructors dominate the time. Nested structs are converted in place up to
`_INLINE` fields; beyond that, and for the items of sequences, by calls.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from threading import RLock
from typing import Any, Final, Protocol

import msgspec

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.facts.omniidl import STAND_IN, mangled
from rtgen.facts.primitives import NUMBERS
from rtgen.runtime.corba.wire_conversions import octets
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic import forms
from rtgen.runtime.marshalling.layouts.nodes import Text
from rtgen.runtime.marshalling.numeric import NumericArray, listed
from rtgen.runtime.marshalling.source.text import Namespace, entered
from rtgen.runtime.marshalling.source.unions import choices
from rtgen.runtime.openrtm.wire_forms import (
    Items,
    element_of,
    holds_values,
    identity_of,
    is_immutable,
    is_octets,
    is_same,
    kept_struct,
    text_of,
)
from rtgen.runtime.openrtm.wire_objects import (
    BASIC,
    ExceptionOctets,
    Octets,
    as_list,
    class_of,
    from_fixed,
    items_of,
    refill,
    to_fixed,
)

_INLINE = 48
"""Maximum number of fields, including those of nested structs, converted in one function."""

_KEY: Final = "openrtm"
"""Key of the conversions among the compiled functions of a type."""

_LOCK = RLock()
_NEW = object.__new__


class Conversion(Protocol):
    """Functions between values and wire objects, which share no data."""

    @property
    def to(self) -> Callable[[Any], Any]:
        """The function that makes a wire object of a value."""

    @property
    def of(self) -> Callable[[Any], Any]:
        """The function that makes a value of a wire object."""


class Conversions(msgspec.Struct, frozen=True):
    """The conversions of a struct, union or exception.

    `fill` copies a value to a wire object in place: inner objects and items of lists are kept,
    lists of plain values are shared. Exceptions have none.
    """

    to: Callable[[Any], Any]
    of: Callable[[Any], Any]
    fill: Any = None


def conversions_of(descriptor: Any) -> Conversions:
    """Return the conversions of a type. Raises StubsMissingError."""
    conversions: Conversions | None = descriptor.codecs.get(_KEY)
    if conversions is None:
        with _LOCK:
            text = _Source()
            text.names_of(descriptor)
            text.compiled(f"<conversions of {descriptor.name}>")
        conversions = descriptor.codecs[_KEY]
    return conversions


class Signature(msgspec.Struct, frozen=True):
    """What is converted in calls of an operation; an object's type is a `Conversion`.

    `method` is its name in Python at omniORB, `extra` are arguments without a value at rtgen.
    """

    name: str
    method: str
    arguments: Sequence[Descriptor | Conversion]
    results: Sequence[Descriptor | Conversion]
    extra: Sequence[Any] = ()


def calling(signature: Signature) -> Callable[[Any, tuple[object, ...]], object]:
    """Return the function that calls an omniORB object with arguments of rtgen.

    Raises StubsMissingError.
    """
    with _LOCK:
        return _Source().operation(signature, True)


def serving(signature: Signature) -> Callable[..., Any]:
    """Return the function of omniORB's arguments after an invoker of rtgen, which it calls.

    Raises StubsMissingError.
    """
    with _LOCK:
        return _Source().operation(signature, False)


class _Source:
    """The text of conversions, which call each other."""

    def __init__(self) -> None:
        self._names = Namespace()
        for local in ("made", "part", "state", "values", "wire"):
            self._names.free(local)
        self._lines: list[str] = []
        self._begun: dict[int, tuple[Any, tuple[str, ...]]] = {}
        self._waiting: list[Any] = []
        self._count = 0
        self._sizes: dict[int, int] = {}

    def names_of(self, descriptor: Any) -> tuple[str, ...]:
        """Return the names of the functions `to`, `of` and `fill` of a type."""
        short = descriptor.name.rpartition("::")[2]
        conversions: Conversions | None = descriptor.codecs.get(_KEY)
        if conversions is not None:
            return tuple(
                self._names.bind(f"{kind}_{short}", getattr(conversions, kind))
                for kind in Conversions.__struct_fields__
            )
        if id(descriptor) not in self._begun:
            names = (f"{kind}_{short}" for kind in Conversions.__struct_fields__)
            self._begun[id(descriptor)] = descriptor, tuple(
                map(self._names.free, names)
            )
            self._waiting.append(descriptor)
        return self._begun[id(descriptor)][1]

    def compiled(self, file: str) -> dict[str, Any]:
        """Compile the functions of all types; return the namespace."""
        while self._waiting:
            self._declared(self._waiting.pop())
        text = "".join(f"{line}\n" for line in self._lines)
        namespace = self._names.values
        namespace["__name__"] = __name__
        exec(compile(text, entered(text, file), "exec"), namespace)
        for descriptor, names in self._begun.values():
            functions: Any = (namespace.get(name) for name in names)
            descriptor.codecs.setdefault(_KEY, Conversions(*functions))
        return namespace

    def operation(self, signature: Signature, calls: bool) -> Callable[..., Any]:
        """Return the compiled function that calls omniORB's object, or rtgen's invoker."""
        name = self._names.free(signature.name)
        locals_ = [self._local("value") for _ in signature.arguments]
        passed = [
            self._converted(calls, type_, value)
            for type_, value in zip(signature.arguments, locals_, strict=True)
        ]
        extra = [self._shared("extra", each) for each in signature.extra]
        if calls:
            parameters = "wire, values"
            lines = [f"({_tuple(locals_)}) = values"]
            call = f"wire.{signature.method}({', '.join((*passed, *extra))})"
        else:
            parameters = ", ".join(("made", *locals_, *extra))
            lines = []
            call = f"made({signature.name!r}, ({_tuple(passed)}))"
        results = [self._local("value") for _ in signature.results]
        converted = [
            self._converted(not calls, type_, value)
            for type_, value in zip(signature.results, results, strict=True)
        ]
        if len(results) > 1:
            lines += [f"({_tuple(results)}) = {call}", f"return ({_tuple(converted)})"]
        elif results:
            lines += [f"{results[0]} = {call}", f"return {converted[0]}"]
        else:
            lines.append(call)
        self._function(name, parameters, lines)
        functions = self.compiled(f"<call of {signature.name}>")
        function: Callable[..., Any] = functions[name]
        return function

    def _function(self, name: str, parameters: str, lines: Iterable[str]) -> None:
        self._lines.append(f"def {name}({parameters}):")
        self._lines += [f"    {line}" for line in lines]

    # Structs, exceptions, unions.

    def _declared(self, descriptor: Any) -> None:
        """Write the functions of a type."""
        to, of, fill = self._begun[id(descriptor)][1]
        identity = identity_of(descriptor)
        ours = self._bound(descriptor.class_)
        is_raised = isinstance(descriptor, ExceptionDescriptor)
        if holds_values(descriptor):
            way = ExceptionOctets if is_raised else Octets
            through = self._shared("octets", way(descriptor, identity))
            self._function(to, "value", [f"return {through}.to(value)"])
            self._function(of, "wire", [f"return {through}.of(wire)"])
            fresh = f"wire.__dict__.update({through}.to(value).__dict__)"
            self._function(fill, "wire, value", [fresh])
            return
        theirs = self._bound(class_of(identity))
        if is_raised:
            for name, parameter, expression in (
                (to, "value", theirs),
                (of, "wire", ours),
            ):
                arguments = self._members(descriptor, parameter, name == to)
                self._function(name, parameter, [f"return {expression}({arguments})"])
            return
        new = f"wire = {self._bound(_NEW)}({theirs})"
        if isinstance(descriptor, UnionDescriptor):
            self._function(to, "value", [new, f"{fill}(wire, value)", "return wire"])
            self._function(of, "wire", self._of_union(descriptor, ours))
            self._function(fill, "wire, value", self._fill_union(descriptor))
            return
        fields = self._fill_struct(descriptor, "wire", "value", True)
        self._function(to, "value", [new, *fields, "return wire"])
        lines, expression = self._constructed(descriptor, "wire")
        self._function(of, "wire", [*lines, f"return {expression}"])
        fields = self._fill_struct(descriptor, "wire", "value", False)
        self._function(fill, "wire, value", [*fields] or ["pass"])

    def _members(
        self, descriptor: ExceptionDescriptor, parameter: str, outgoing: bool
    ) -> str:
        """Return the converted members of an exception as arguments."""
        names = (
            (m.attribute if outgoing else mangled(m.name), m.type)
            for m in descriptor.members
        )
        return ", ".join(
            self._converted(outgoing, type_, f"{parameter}.{name}")
            for name, type_ in names
        )

    def _fill_struct(
        self, struct: StructDescriptor, wire: str, value: str, fresh: bool
    ) -> Iterator[str]:
        if fresh and struct.opaque:
            yield f"{wire}.{STAND_IN} = 0"
        for member in struct.members:
            there = f"{wire}.{mangled(member.name)}"
            here = f"{value}.{member.attribute}"
            inner = self._inner(member.type)
            if inner is None:
                yield from self._fill_field(member.type, there, here, fresh)
                continue
            inner_wire = self._local(f"wire_{member.name}")
            inner_value = self._local(f"value_{member.name}")
            class_ = self._bound(class_of(identity_of(inner)))
            target = f"{there} = {self._bound(_NEW)}({class_})" if fresh else there
            yield f"{inner_wire} = {target}"
            yield f"{inner_value} = {here}"
            yield from self._fill_struct(inner, inner_wire, inner_value, fresh)

    def _fill_field(
        self, type_: Descriptor, there: str, here: str, fresh: bool
    ) -> Iterator[str]:
        type_ = plain(type_)
        element = kept_struct(type_)
        if not fresh and isinstance(type_, StructDescriptor):
            yield f"{self.names_of(type_)[2]}({there}, {here})"
        elif not fresh and element is not None:
            to, _, fill = self.names_of(element)
            yield f"if {here} or {there}:"
            yield f"    {self._bound(refill)}({there}, {here}, {fill}, {to})"
        elif not fresh and is_same(type_):
            yield f"{there} = {self._numbers(as_list, type_, here) or here}"
        else:
            yield f"{there} = {self._converted(True, type_, here)}"

    def _constructed(
        self, struct: StructDescriptor, wire: str
    ) -> tuple[list[str], str]:
        """Return the statements that a value needs, and the expression that makes it."""
        lines: list[str] = []
        arguments: list[str] = []
        for member in struct.members:
            there = f"{wire}.{mangled(member.name)}"
            inner = self._inner(member.type)
            if inner is None:
                arguments.append(self._converted(False, member.type, there))
                continue
            variable = self._local(f"wire_{member.name}")
            more, expression = self._constructed(inner, variable)
            lines += [f"{variable} = {there}", *more]
            arguments.append(expression)
        return lines, f"{self._bound(struct.class_)}({', '.join(arguments)})"

    def _inner(self, type_: Descriptor) -> StructDescriptor | None:
        """Return the struct of a member that is converted in place."""
        type_ = plain(type_)
        if isinstance(type_, StructDescriptor) and self._size(type_) <= _INLINE:
            return type_
        return None

    def _size(self, struct: StructDescriptor) -> int:
        """Return the number of fields and inner structs; one above `_INLINE` for calls."""
        size = self._sizes.get(id(struct))
        if size is None:
            size = 1 + _INLINE * holds_values(struct)
            for member in struct.members:
                if size > _INLINE:
                    break
                inner = plain(member.type)
                size += self._size(inner) if isinstance(inner, StructDescriptor) else 1
            self._sizes[id(struct)] = size
        return size

    def _fill_union(self, union: UnionDescriptor) -> Iterator[str]:
        yield "state = wire.__dict__"
        yield f'state["_d"] = {self._converted(True, union.switch, "value.discriminator")}'
        yield "part = value.value"
        yield "selected = value.discriminator"
        yield from self._branches(union, True)
        yield 'state["_v"] = part'

    def _of_union(self, union: UnionDescriptor, ours: str) -> Iterator[str]:
        yield f"selected = {self._converted(False, union.switch, 'wire._d')}"
        yield "part = wire._v"
        yield from self._branches(union, False)
        yield f"return {ours}(selected, part)"

    def _branches(self, union: UnionDescriptor, outgoing: bool) -> Iterator[str]:
        """Yield the statements that convert `part`; without a branch it is no value."""
        arms = [
            (head, self._converted(outgoing, branch.type, "part"))
            for head, branch in choices(union, "selected")
        ]
        if any(expression != "part" for _, expression in arms):
            for head, expression in arms:
                yield head
                yield f"    part = {expression}"

    # Expressions.

    def _converted(
        self, outgoing: bool, type_: Descriptor | Conversion, value: str
    ) -> str:
        """Return an expression for a wire form, or for a value; they share no data."""
        if not isinstance(type_, msgspec.Struct):
            way = "to" if outgoing else "of"
            return f"{self._shared('objects', type_)}.{way}({value})"
        described: Any = plain(type_)
        if is_immutable(described):
            return value
        match described:
            case _ if is_octets(described):
                return f"{self._bound(octets)}({value})" if outgoing else value
            case FixedDescriptor(digits, scale):
                if outgoing:
                    return f"{self._bound(to_fixed)}({value}, {digits}, {scale})"
                return f"{self._bound(from_fixed)}({value})"
            case SequenceDescriptor() | ArrayDescriptor():
                return self._items(outgoing, described, value)
            case EnumDescriptor(repository_id, class_=class_):
                if outgoing:
                    return f"{self._shared('items', items_of(repository_id))}[{value}]"
                return f"{self._shared('members', tuple(class_))}[{value}._v]"
            case StructDescriptor() | UnionDescriptor():
                to, of, _ = self.names_of(described)
                return f"{to if outgoing else of}({value})"
            case PrimitiveDescriptor(name):
                through = BASIC[name]
            case _:
                through = Octets(described, described.repository_id)
        way = "to" if outgoing else "of"
        return f"{self._shared('octets', through)}.{way}({value})"

    def _items(self, outgoing: bool, type_: Items, value: str) -> str:
        """Return an expression for the items of a sequence or array."""
        if type_.numeric != "list":
            return self._formed(outgoing, type_, value)
        text = text_of(type_)
        if text is not None and not outgoing:
            is_text = text is Text.CHARACTERS
            return f'"".join({value})' if is_text else f"bytes({value})"
        numbers = "" if text else self._numbers(listed, type_, value)
        if numbers and outgoing:
            return numbers
        return self._list(outgoing, type_, value)

    def _list(self, outgoing: bool, type_: Items, value: str) -> str:
        item = self._local("item")
        converted = self._converted(outgoing, element_of(type_), item)
        return (
            f"list({value})"
            if converted == item
            else f"[{converted} for {item} in {value}]"
        )

    def _numbers(
        self, helper: Callable[..., Any], type_: Descriptor, value: str
    ) -> str:
        """Return a list of numbers made by a helper; empty for another type."""
        if not isinstance(type_, Items) or forms.is_octet(type_.element):
            return ""
        if not forms.is_in_buffers(type_.element):
            return ""
        depth = len(type_.dimensions) if isinstance(type_, ArrayDescriptor) else 1
        further = f", {depth}" if depth > 1 else ""
        return f"{self._bound(helper)}({value}{further})"

    def _formed(self, outgoing: bool, type_: Items, value: str) -> str:
        """Return an expression for numbers or structs in another form than omniORB's lists."""
        element: Any = plain(type_.element)
        is_struct = isinstance(element, StructDescriptor)
        described = self._shared("described", type_)
        if outgoing and is_struct:
            structs = f"{self._bound(forms.listed)}({described}, {value})"
            return self._list(True, type_, structs)
        if outgoing:
            return f"{self._bound(listed)}({value})"
        if is_struct:
            structs = self._list(False, type_, value)
            return f"{self._bound(forms.formed)}({described}, {structs})"
        if type_.numeric == "numpy":
            return f"{self._bound(forms.formed)}({described}, {value})"
        code = NUMBERS[element.name].code
        many = f"{self._bound(NumericArray)}({code!r}, {value})"
        return f"{many} if len({value}) > {MAX_LIST_LENGTH} else [*{value}]"

    def _local(self, name: str) -> str:
        """Return the name of a new variable; numbers keep names of many short."""
        self._count += 1
        return self._names.free(f"{name}_{self._count}")

    def _shared(self, name: str, value: Any) -> str:
        """Return the name of an object in the namespace."""
        return self._names.bind(f"{name}_{len(self._names.values)}", value)

    def _bound(self, value: Any) -> str:
        return self._names.bind(value.__name__, value)


def _tuple(items: Iterable[str]) -> str:
    return "".join(f"{item}, " for item in items)
