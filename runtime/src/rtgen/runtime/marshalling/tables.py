"""Tables of types for the codecs in C of `rtgen-speed`, and the judgement which types have one.

A type stays in Python, without a table, if a part of it is a valuetype, a type code, an object
reference, a mutable union, or a structured numpy array. For octets and values that a table does not
cover, the codec calls the function in Python.

The environment variable RTGEN_CODEC chooses: `python`, or `c`, which requires `rtgen-speed`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from enum import Enum
from functools import cache, partial
from math import prod
from types import ModuleType
from typing import Any, Final, Literal, TypeAlias

import msgspec

from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.runtime.marshalling.descriptors import (
    ANY,
    UNKNOWN,
    BoxDescriptor,
    Descriptor,
    ExceptionDescriptor,
    InterfaceDescriptor,
    PrimitiveDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
    until_registration,
)
from rtgen.runtime.marshalling.layouts.envelopes import identifier
from rtgen.runtime.marshalling.layouts.formats import CLASSIC, Format, UnsupportedError
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Dynamic,
    Form,
    Group,
    Member,
    MemberList,
    Node,
    Optional,
    Parameter,
    Records,
    Reference,
    Repeat,
    Text,
    TextArray,
    TextSequence,
)
from rtgen.runtime.marshalling.layouts.trees import (
    body_of,
    has_headers,
    has_list,
    is_delimited,
    tree_of,
)
from rtgen.runtime.marshalling.numeric import NumericArray
from rtgen.runtime.marshalling.octets import (
    fixed_octets,
    fixed_value,
    quad_octets,
    quad_value,
)
from rtgen.runtime.marshalling.source.conversions import enumerators

_Hook: TypeAlias = Callable[[Any, bool], Any]
_Entry: TypeAlias = tuple[Descriptor, bytes, Any]
"""A type, the octets of its type code, and a codec of its values; None if it has none (`null`)."""
_Member: TypeAlias = tuple[str, int, int, int, bool, bool, bool]

INTERFACE: Final = 3
"""The version of the tables and of the calls on `rtgen_speed`."""

_MODES = {
    "to_cdr": 0,
    "to_payload": 0,
    "from_cdr": 1,
    "from_prefix": 2,
    "read": 3,
    "_snapshot_": 4,
}
"""The kinds of functions that a codec in C takes the place of, and its modes."""

_NUMBERS = {code: number for number, code in enumerate("bBhHiIqQfd")}
_TEXTS = {text: number for number, text in enumerate(Text)}
_FORMS = {"list": 0, "array": 1, "numpy": 2}
_SIGNED = 1 << 63
_DECLARED = StructDescriptor, ExceptionDescriptor, UnionDescriptor
_MAX_CACHED = 256

_HEADS: tuple[dict[int, _Entry], dict[int, _Entry]] = (
    until_registration({}),
    until_registration({}),
)
"""By byte order (big, little) and the identity of a type: what an `any` with it begins with."""
_TYPES: tuple[dict[bytes, _Entry], dict[bytes, _Entry]] = (
    until_registration({}),
    until_registration({}),
)
"""By byte order and the octets of a type code: its type."""


@cache
def speed() -> ModuleType | None:
    """Return `rtgen_speed` if it is installed and wanted. Raises ImportError if it is required."""
    choice = os.environ.get("RTGEN_CODEC", "")
    if choice not in ("", "c", "python"):
        raise ImportError(f"RTGEN_CODEC is {choice!r}, neither c nor python")
    if choice == "python":
        return None
    try:
        import rtgen_speed  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        if choice:
            raise
        return None
    if rtgen_speed.INTERFACE != INTERFACE:
        if choice:
            raise ImportError("rtgen-speed and rtgen-runtime are of different versions")
        return None
    module: ModuleType = rtgen_speed
    prepare(module)
    return module


def prepare(module: ModuleType) -> None:
    """Give the module what it needs of the runtime."""
    module.set_numeric_array(NumericArray)
    class_ = UNKNOWN[PrimitiveDescriptor]
    make_head, make_type = partial(_head_of_any, module), partial(_type_of_any, module)
    module.set_any(class_, _HEADS, make_head, _TYPES, make_type)


def codec(
    kind: str, descriptor: Any, format_: Format, in_python: Callable[[], Any]
) -> Any:
    """Return the codec in C of a kind; None if the function in Python is used instead.

    `in_python` returns that function, which is made when it is first needed.
    """
    module = speed()
    mode = _MODES.get(kind)
    if module is None or mode is None:
        return None
    copies = kind == "_snapshot_"
    if copies:
        format_ = Format(2) if has_headers(descriptor) else format_
    key = ((_table, copies), format_)
    try:
        if key not in descriptor.codecs:
            descriptor.codecs[key] = _table(module, descriptor, format_, copies)
        table, root = descriptor.codecs[key]
    except (_UncoveredError, UnsupportedError):
        return None
    number = -1
    if kind == "to_payload":
        number = identifier(descriptor, format_.version, False)
    name = f"{kind} of {descriptor.name}"
    bound = isinstance(descriptor, _DECLARED)
    made = module.Codec(table, root, mode, number, bound, name, in_python)
    return made if copies else made.direct


def _head_of_any(module: ModuleType, type_: Any, little: bool) -> _Entry | None:
    """Return what an `any` with this type begins with; None if it is left to Python."""
    from rtgen.runtime.marshalling.type_codes import type_code_octets

    try:
        inner = _codec_in_any(module, type_)
    except (_UncoveredError, UnsupportedError):
        return None
    kind, parameters = type_code_octets(type_, little)
    entry = type_, kind.to_bytes(4, _order(little)) + parameters, inner
    table = _HEADS[little]
    if len(table) >= _MAX_CACHED:
        table.clear()
    table[id(type_)] = entry
    return entry


def _type_of_any(module: ModuleType, octets: bytes, little: bool) -> _Entry | None:
    """Return the type of a type code; None if it is left to Python."""
    from rtgen.runtime.marshalling.type_codes import MAX_CACHED_OCTETS, type_at_start

    type_ = type_at_start(octets, little)
    try:
        inner = _codec_in_any(module, type_)
    except (_UncoveredError, UnsupportedError):
        return None
    entry = type_, octets, inner
    table = _TYPES[little]
    if len(octets) <= MAX_CACHED_OCTETS:
        if len(table) >= _MAX_CACHED:
            table.clear()
        table[octets] = entry
    return entry


def _codec_in_any(module: ModuleType, type_: Any) -> Any:
    """Return the codec of values in an `any`, which compiled codecs in Python marshal, too."""
    from rtgen.runtime.marshalling.dynamic.direct import (
        compiled_class,
        has_empty_elements,
    )

    described = plain(type_)
    match described:
        case PrimitiveDescriptor("null" | "void"):
            return None
        case StructDescriptor() | UnionDescriptor():
            is_covered = compiled_class(described) is not None
        case ExceptionDescriptor() | InterfaceDescriptor():
            is_covered = False
        case ValueDescriptor() | BoxDescriptor():
            is_covered = False
        case _:
            is_covered = not (has_headers(described) or has_empty_elements(described))
    if not is_covered:
        raise _UncoveredError
    table, root = _table(module, described, CLASSIC, False)
    return module.Codec(table, root, _MODES["read"], -1, False, "any", _MODES.get)


class _UncoveredError(Exception):
    """Raised for a type without a table."""


def _table(
    module: ModuleType, descriptor: Any, format_: Format, copies: bool
) -> tuple[Any, int]:
    table = _Table(module, format_, copies)
    root = table.whole(descriptor)
    return module.Table(table.nodes), root


class _Table:
    """The nodes of a table, as keyword arguments of `Table`; they refer to others by their number.

    `copies`: the table of a copier.
    """

    def __init__(self, module: ModuleType, format_: Format, copies: bool) -> None:
        self.nodes: list[dict[str, Any]] = []
        self._module = module
        self._format = format_
        self._copies = copies
        self._unset = copies and format_.version == 2
        self._declared: dict[int, int] = {}

    def whole(self, descriptor: Any) -> int:
        """Return the node of a value that is marshalled alone."""
        if isinstance(descriptor, _DECLARED):
            return self._of_declared(descriptor)
        return self._of(tree_of(descriptor, self._format))

    def _add(self, kind: str, **fields: Any) -> int:
        self.nodes.append({"kind": getattr(self._module, kind), **fields})
        return len(self.nodes) - 1

    def _of(self, node: Node) -> int:
        match node:
            case Atom():
                return self._atom(node)
            case AtomArray(atom=atom, dimensions=lengths, form=form):
                return self._numbers(
                    atom, form, lengths, length=prod(lengths), lengths=lengths
                )
            case AtomSequence(atom=Atom(form=Form.WORD), bound=bound):
                return self._add("WORDS", bound=bound, shared=1)
            case AtomSequence(atom=atom, bound=bound, form=form):
                return self._numbers(atom, form, (), bound=bound)
            case TextArray(text=text, length=length):
                return self._text(text, length=length)
            case TextSequence(text=text):
                return self._text(text, bound=node.most)
            case Records(form="list", element=element, bound=bound, length=length):
                return self._repeated(element, bound, length, node.size)
            case Repeat(key=None, element=element, bound=bound, length=length):
                return self._repeated(element, bound, length, node.minimum)
            case Repeat(key=key, element=element, bound=bound, minimum=minimum):
                assert key is not None
                keys, items = self._of(key), self._of(element)
                return self._add(
                    "MAP", key=keys, child=items, bound=bound, minimum=minimum
                )
            case Group(type=type_, members=members):
                nodes = [(name, self._of(inner)) for name, inner in members]
                return self._members("STRUCT", type_.class_, nodes)
            case MemberList():
                return self._list(node)
            case Call(type=type_):
                return self._of_declared(type_)
            case Delimited(node=inner):
                return self._around("DELIMITED", inner)
            case Optional(node=inner):
                return self._around("OPTIONAL", inner)
            case Parameter(in_list=False, id=number, must_understand=needed):
                return self._around(
                    "PARAMETER", node.node, id=number, must_understand=needed
                )
            case Reference() if self._copies:
                return self._add("ANY", shared=1)
            case Dynamic(type=type_) if type_ == ANY and not self._copies:
                return self._add("ANY")
        raise _UncoveredError

    def _atom(self, atom: Atom) -> int:
        fields: dict[str, Any] = {"align": atom.align, "size": atom.size, "shared": 1}
        number = _NUMBERS.get(atom.code)
        described = atom.type
        if getattr(described, "class_", atom) is None:
            raise _UncoveredError
        match atom.form:
            case Form.NUMBER if number is not None:
                self.nodes.append({"kind": number, "code": ord(atom.code), **fields})
                return len(self.nodes) - 1
            case Form.BOOLEAN | Form.CHARACTER | Form.WIDE_CHARACTER | Form.UNIT:
                return self._add(atom.form.name, **fields)
            case Form.ENUMERATOR if number is not None:
                fields |= {"type": described.class_, "first": enumerators(described)}
                return self._add("ENUMERATOR", form=number, **fields)
            case Form.FLAGS if number is not None:
                class_ = described.class_
                fields |= {"type": class_, "first": class_._value2member_map_}
                return self._add("FLAGS", form=number, bound=atom.digits, **fields)
        pack, unpack = _hooks(atom)
        return self._add("HOOK", first=pack, second=unpack, **fields)

    def _numbers(
        self, atom: Atom, form: str, shape: tuple[int, ...], **fields: Any
    ) -> int:
        child = self._atom(atom)
        if atom.form is Form.NUMBER:
            fields |= {"form": _FORMS[form], "code": ord(atom.code)}
            if form == "numpy":
                fields["first"] = _maker(atom.code, shape)
            elif form == "array":
                fields["minimum"] = MAX_LIST_LENGTH
        return self._add("NUMBERS", child=child, **fields)

    def _text(self, text: Text, **fields: Any) -> int:
        shared = text is not Text.OCTETS
        return self._add("TEXT", form=_TEXTS[text], shared=shared, **fields)

    def _repeated(
        self, element: Node, bound: int | None, length: int | None, minimum: int
    ) -> int:
        fields = {"bound": bound, "length": length, "minimum": minimum}
        return self._around("REPEAT", element, **fields)

    def _around(self, kind: str, inner: Node, **fields: Any) -> int:
        child = self._of(inner)
        if kind != "REPEAT":
            fields["shared"] = self.nodes[child].get("shared")
        return self._add(kind, child=child, **fields)

    def _members(
        self, kind: str, class_: Any, nodes: list[tuple[str, int]], **fields: Any
    ) -> int:
        """Add a struct or union of members, given by their attributes and nodes."""
        members = tuple((name, node, 0, 0, False, False, False) for name, node in nodes)
        return self._aggregate(kind, class_, members, **fields)

    def _aggregate(
        self, kind: str, class_: Any, members: tuple[_Member, ...], **fields: Any
    ) -> int:
        if class_ is None:
            raise _UncoveredError
        fields |= {"type": class_, "plain": is_plain(class_, [m[0] for m in members])}
        return self._add(kind, members=members, unset=self._unset, **fields)

    def _list(self, node: MemberList) -> int:
        members: list[_Member] = []
        version = self._format.version
        for name, member in node.members:
            header = member.header if isinstance(member, Member) else 0
            traits = member.optional, member.key, member.must_understand
            inner = self._of(member.node)
            members.append((name, inner, member.id, header, *traits))
        return self._aggregate(
            "LIST", node.type.class_, tuple(members), version=version
        )

    def _of_declared(self, descriptor: Any) -> int:
        """Return the node of a struct, exception or union, which may contain itself."""
        number = self._declared.get(id(descriptor))
        if number is not None:
            return number
        number = self._declared[id(descriptor)] = len(self.nodes)
        self.nodes.append({})
        if isinstance(descriptor, UnionDescriptor):
            inner = self._union(descriptor)
        else:
            inner = self._of(body_of(descriptor, self._format))
        if is_delimited(descriptor, self._format):
            self.nodes[number] = {"kind": self._module.DELIMITED, "child": inner}
        else:
            self.nodes[number] = self.nodes[inner]
        return number

    def _union(self, descriptor: UnionDescriptor) -> int:
        if has_list(descriptor, self._format) and not self._copies:
            raise _UncoveredError
        switch = self._of(tree_of(descriptor.switch, self._format))
        labels: list[tuple[int, int]] = []
        fields: dict[str, Any] = {}
        for branch in descriptor.branches:
            node = self._of(tree_of(branch.type, self._format))
            labels += ((_label(label), node) for label in branch.labels)
            if branch.default:
                fields["otherwise"] = node
        nodes = [("discriminator", switch), ("value", switch)]
        fields |= {"child": switch, "labels": tuple(labels)}
        return self._members("UNION", descriptor.class_, nodes, **fields)


def _label(label: Any) -> int:
    """Return a label as a number of 64 bits."""
    if isinstance(label, Enum):
        label = label.value
    number = ord(label) if isinstance(label, str) else int(label)
    return (number + _SIGNED) % (2 * _SIGNED) - _SIGNED


def is_plain(class_: Any, attributes: Sequence[str]) -> bool:
    """Return whether instances are made by filling the slots of these attributes alone."""
    fields = getattr(class_, "__struct_fields__", None)
    return (
        type(class_) is type(msgspec.Struct)
        and fields is not None
        and sorted(fields) == sorted(attributes)
        and not hasattr(class_, "__post_init__")
        and class_.__init__ is msgspec.Struct.__init__
        and class_.__new__ is msgspec.Struct.__new__
        and class_.__getattribute__ is msgspec.Struct.__getattribute__
    )


def _hooks(atom: Atom) -> tuple[_Hook, _Hook]:
    """Return the functions from a value to its octets, and back; `little` is the byte order."""
    match atom.form:
        case Form.QUAD:
            return quad_octets, quad_value
        case Form.FIXED:
            digits, scale = atom.digits, atom.scale
            return (
                lambda value, little: fixed_octets(value, digits, scale),
                lambda octets, little: fixed_value(octets, digits, scale),
            )
        case Form.BITS:
            size, from_number = atom.size, atom.type.class_.from_number
            return (
                lambda value, little: value.to_number().to_bytes(size, _order(little)),
                lambda octets, little: from_number(
                    int.from_bytes(octets, _order(little))
                ),
            )
    raise _UncoveredError


def _order(little: bool) -> Literal["little", "big"]:
    return "little" if little else "big"


def _maker(code: str, lengths: tuple[int, ...]) -> Callable[[bytearray], Any]:
    """Return the function that makes a numpy array of octets in the machine's byte order."""
    import numpy

    type_ = numpy.dtype(code)

    def made(octets: bytearray) -> Any:
        if not octets:
            return numpy.empty(0, type_)
        array = numpy.frombuffer(octets, type_)
        return array.reshape(lengths) if lengths else array

    return made
