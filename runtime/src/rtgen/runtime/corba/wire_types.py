"""omniORBpy's type descriptors of generated types, with conversions of values.

omniORBpy marshals any object with the attributes named by a descriptor, and constructs values by
calling the class in the descriptor. So data classes, enums and unions need no conversion. Types
that omniORBpy represents by its own classes (`any`, type codes, `fixed`, object references), and
types that contain them, are converted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from decimal import Context, Decimal
from functools import partial
from operator import attrgetter
from types import SimpleNamespace
from typing import Any, Protocol, TypeAlias

import msgspec
import omniORB
from omniORB import CORBA, tcInternal

from rtgen.runtime.cdr import UserException
from rtgen.runtime.corba.wire_anys import TYPE_CODE, Anys
from rtgen.runtime.corba.wire_conversions import (
    Convert,
    WireType,
    WireUnion,
    each,
    int8_of,
    latin_octet,
    latin_octets,
    latin_text,
    octet_of,
    octets,
    octets_of,
    through,
)
from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    class_of,
    plain,
)
from rtgen.runtime.marshalling.dynamic.forms import (
    formed,
    is_in_buffers,
    is_octet,
    listed,
)
from rtgen.runtime.marshalling.layouts.trees import parts
from rtgen.runtime.marshalling.octets import (
    fixed_octets,
    wide_character,
    wide_character_value,
)
from rtgen.runtime.services.servants import MarshalError, Servant
from rtgen.runtime.values import DynamicUnion, DynamicValue

Interface: TypeAlias = type[Servant] | None

_PRIMITIVES = {
    "null": tcInternal.tv_null,
    "void": tcInternal.tv_void,
    "short": tcInternal.tv_short,
    "long": tcInternal.tv_long,
    "long long": tcInternal.tv_longlong,
    "unsigned short": tcInternal.tv_ushort,
    "unsigned long": tcInternal.tv_ulong,
    "unsigned long long": tcInternal.tv_ulonglong,
    "uint8": tcInternal.tv_octet,
    "octet": tcInternal.tv_octet,
    "boolean": tcInternal.tv_boolean,
    "float": tcInternal.tv_float,
    "double": tcInternal.tv_double,
}
"""Types with the same representation in both."""

_SWITCHES = (
    "short",
    "long",
    "long long",
    "unsigned short",
    "unsigned long",
    "unsigned long long",
    "boolean",
    "char",
)
_CHAR, _INT8 = PrimitiveDescriptor("char"), PrimitiveDescriptor("int8")
_WIDE_CHARACTER = (tcInternal.tv_array, tcInternal.tv_octet, 3)
"""A wchar in the encoding of GIOP 1.2: omniORBpy 4.3.3 cannot read those that it writes."""
_DIGITS = Context(prec=31)


class WireException(msgspec.Struct, frozen=True):
    """A user exception: `raised` converts to omniORBpy's class, `caught` from it."""

    descriptor: Any
    raised: Convert
    caught: Convert


class Objects(Protocol):
    """Resolves object references."""

    def exported(self, value: Any, interface: Interface) -> Any:
        """Convert a servant, a stub or an `ObjectReference` to omniORBpy's reference."""

    def imported(self, reference: Any, interface: Interface) -> Any:
        """Convert omniORBpy's reference to a stub, or to an `ObjectReference` without interface."""


class WireTypes:
    """The types of one ORB. `of` and `exception` raise MarshalError for unsupported types."""

    def __init__(self, objects: Objects, anys: Anys | None = None) -> None:
        self._objects = objects
        self._anys = anys or Anys(self._separate)
        # Keeps each descriptor alive, so that its id stays unique.
        self._made: dict[int, tuple[Descriptor, WireType]] = {}
        self._exceptions: dict[type[UserException], WireException] = {}
        self._begun: dict[int, list[Any]] = {}

    def of(self, descriptor: Any, interface: Interface = None) -> WireType:
        """Return the type of a descriptor; with an interface, that of references to its objects."""
        if interface is not None:
            return self._reference(descriptor, interface)
        found = self._made.get(id(descriptor))
        if found is None:
            found = self._made[id(descriptor)] = descriptor, self._type(descriptor)
        return found[1]

    def _separate(self, descriptor: Any) -> WireType:
        """Return the type of a descriptor, which a peer may have sent, without keeping it."""
        return WireTypes(self._objects, self._anys).of(descriptor)

    def exception(self, class_: type[UserException]) -> WireException:
        """Return the wire form of an exception."""
        found = self._exceptions.get(class_)
        if found is None:
            found = self._exceptions[class_] = self._exception(class_)
        return found

    def _type(self, descriptor: Any) -> WireType:
        made: Any
        match descriptor:
            case LinkDescriptor():
                return self._link(descriptor)
            case AliasDescriptor(repository_id, name, target=target):
                inner = self.of(target)
                made = tcInternal.tv_alias, repository_id, _last(name), inner.descriptor
                return WireType(made, inner.outgoing, inner.incoming)
            case PrimitiveDescriptor(name) if name in _PRIMITIVES:
                return WireType(_PRIMITIVES[name])
            case PrimitiveDescriptor("any"):
                return self._anys.type
            case PrimitiveDescriptor("CORBA::TypeCode"):
                return TYPE_CODE
            case PrimitiveDescriptor("char"):
                return WireType(tcInternal.tv_octet, latin_octet, chr)
            case PrimitiveDescriptor("wchar"):
                return WireType(_WIDE_CHARACTER, wide_character, wide_character_value)
            case PrimitiveDescriptor("int8"):
                return WireType(tcInternal.tv_octet, octet_of, int8_of)
            case PrimitiveDescriptor("Object"):
                return self._reference(descriptor, None)
            case InterfaceDescriptor(local=False):
                return self._reference(descriptor, None)
            case StringDescriptor(wide, bound):
                kind = tcInternal.tv_wstring if wide else tcInternal.tv_string
                return WireType((kind, bound or 0))
            case FixedDescriptor(digits, scale):
                return _fixed(digits, scale)
            case SequenceDescriptor(element, bound):
                inner = self.of(element)
                made = tcInternal.tv_sequence, inner.descriptor, bound or 0
                return WireType(made, *_formed(descriptor, _items(element, inner)))
            case ArrayDescriptor(element, (length, *rest)):
                rows = ArrayDescriptor(element, tuple(rest)) if rest else element
                inner = self.of(rows)
                made = tcInternal.tv_array, inner.descriptor, length
                return WireType(made, *_formed(descriptor, _items(rows, inner)))
            case EnumDescriptor():
                return _enum(descriptor)
            case StructDescriptor(opaque=False):
                return self._recursive(descriptor, self._struct)
            case UnionDescriptor():
                return self._recursive(descriptor, self._union)
            case ExceptionDescriptor(class_=class_) if class_ is not None:
                made = self.exception(class_)
                return WireType(made.descriptor, made.raised, made.caught)
        raise MarshalError(f"values of {descriptor} cannot travel by CORBA")

    def _recursive(self, descriptor: Any, make: Callable[[Any], WireType]) -> WireType:
        cell = self._begun[id(descriptor)] = [descriptor.repository_id]
        try:
            made = make(descriptor)
        finally:
            del self._begun[id(descriptor)]
        cell[0] = made.descriptor
        return made

    def _link(self, descriptor: LinkDescriptor) -> WireType:
        """Return a type used within its own definition, possibly still incomplete."""
        target = plain(descriptor)
        cell = self._begun.get(id(target))
        if cell is None:
            return self.of(target)
        made = tcInternal.tv__indirect, cell
        if not _converted([target], set()):
            return WireType(made)
        # Values are converted when the enclosing value is constructed.
        return WireType(made, lambda value: self.of(target).outgoing(value))  # type: ignore[misc]

    def _struct(self, descriptor: StructDescriptor) -> WireType:
        class_ = class_of(descriptor) or _dynamic_maker(descriptor)
        members = self._members(descriptor.members)
        head = descriptor.repository_id, _last(descriptor.name)
        if not _converted([descriptor], set()):
            made = tcInternal.tv_struct, class_, *head, *members.parts
            return WireType(made, _plain_copy(descriptor))
        made = tcInternal.tv_struct, members.maker(class_), *head, *members.parts
        return WireType(made, members.outgoing)

    def _members(self, members: Iterable[Any]) -> _Members:
        for member in members:
            if member.optional:
                raise MarshalError(f"{member.name} is optional, which CORBA has not")
        return _Members([(m.name, m.attribute, self.of(m.type)) for m in members])

    def _union(self, descriptor: UnionDescriptor) -> WireType:
        class_ = class_of(descriptor) or partial(DynamicUnion, descriptor)
        switch = plain(descriptor.switch)
        if not (
            isinstance(switch, EnumDescriptor)
            or (isinstance(switch, PrimitiveDescriptor) and switch.name in _SWITCHES)
        ):
            raise MarshalError(f"{descriptor} switches on {switch}, which CORBA cannot")
        discriminator = self.of(descriptor.switch)
        if switch == _CHAR:
            discriminator = WireType(tcInternal.tv_char)
        if discriminator.outgoing is not None and class_of(switch) is not None:
            raise MarshalError(
                f"{descriptor} switches on {switch} with numbers of its own"
            )
        wires = [self.of(branch.type) for branch in descriptor.branches]
        entries: list[tuple[Any, str, Any]] = []
        default = -1
        for branch, wire in zip(descriptor.branches, wires, strict=True):
            labels = [_label(switch, label) for label in branch.labels]
            if branch.default:
                default = len(entries) + len(labels)
                labels.append(_unused(switch, descriptor))
            entries += [(label, branch.name, wire.descriptor) for label in labels]
        cases = {e[0]: e for i, e in enumerate(entries) if i != default}
        converted = _converted([descriptor], set())
        if not converted:
            read: Any = class_of(descriptor) or DynamicUnion
            read._d, read._v = _DISCRIMINATOR, _VALUE
        made = (
            tcInternal.tv_union,
            (
                _union_maker(class_, descriptor, discriminator, wires)
                if converted
                else class_
            ),
            descriptor.repository_id,
            _last(descriptor.name),
            discriminator.descriptor,
            default,
            tuple(entries),
            entries[default] if default >= 0 else None,
            cases,
        )
        if not converted:
            return WireType(made, _plain_copy(descriptor))
        return WireType(made, _union_outgoing(descriptor, discriminator, wires))

    def _exception(self, class_: type[UserException]) -> WireException:
        descriptor = class_._descriptor_
        members = self._members(descriptor.members)
        name = _last(descriptor.name)

        def keep(self: Any, *values: Any) -> None:
            CORBA.UserException.__init__(self, *values)
            for (member, _, _), value in zip(members.entries, values, strict=True):
                setattr(self, member, value)

        parts = {"_NP_RepositoryId": descriptor.repository_id, "__init__": keep}
        theirs = type(name, (CORBA.UserException,), parts)
        # omniORBpy passes the exception itself to a client in the same process.
        uncopied = type(name, (theirs,), {})
        head = tcInternal.tv_except, theirs, descriptor.repository_id, name
        code = tcInternal.TypeCode_except((*head, *members.parts))

        def raised(error: Any) -> Any:
            return uncopied(*vars(members.outgoing(error)).values())

        def caught(error: Any) -> Any:
            if isinstance(error, uncopied):
                error = omniORB.cdrUnmarshal(
                    code, omniORB.cdrMarshal(code, error, 1), 1
                )
            return class_(
                *members.incoming(getattr(error, m) for m, _, _ in members.entries)
            )

        return WireException(code._d, raised, caught)

    def _reference(self, descriptor: Any, interface: Interface) -> WireType:
        objects = self._objects

        def outgoing(value: Any) -> Any:
            return objects.exported(value, interface)

        def incoming(reference: Any) -> Any:
            return objects.imported(reference, interface)

        made = CORBA._d_Object
        if isinstance(descriptor, InterfaceDescriptor):
            kind = tcInternal.tv_objref
            if descriptor.abstract:
                kind = tcInternal.tv_abstract_interface
            made = kind, descriptor.repository_id, _last(descriptor.name)
        return WireType(made, outgoing, incoming)


class _Members:
    """The members of a struct or an exception: name, attribute, type."""

    def __init__(self, entries: Sequence[tuple[str, str, WireType]]) -> None:
        self.entries = entries
        self.parts = [
            part for name, _, wire in entries for part in (name, wire.descriptor)
        ]

    def outgoing(self, value: Any) -> SimpleNamespace:
        """Return an object with the members for omniORBpy to read."""
        made = SimpleNamespace()
        for name, attribute, wire in self.entries:
            setattr(made, name, through(wire.outgoing, getattr(value, attribute)))
        return made

    def incoming(self, values: Iterable[Any]) -> Iterable[Any]:
        """Convert the values of the members in order."""
        for (_, _, wire), value in zip(self.entries, values, strict=True):
            yield through(wire.incoming, value)

    def maker(self, class_: Callable[..., Any]) -> Convert:
        """Return the function by which omniORBpy constructs a struct."""
        return lambda *values: class_(*self.incoming(values))


_DISCRIMINATOR = property(attrgetter("discriminator"))
_VALUE = property(attrgetter("value"))


def _dynamic_maker(descriptor: StructDescriptor) -> Callable[..., DynamicValue]:
    """Return the function that constructs values of a struct without a class."""
    names = [member.attribute for member in descriptor.members]
    return lambda *values: DynamicValue(
        descriptor, dict(zip(names, values, strict=True))
    )


def _union_maker(
    class_: Callable[..., Any],
    descriptor: UnionDescriptor,
    switch: WireType,
    wires: Sequence[WireType],
) -> Callable[[Any, Any], Any]:
    def make(discriminator: Any, value: Any) -> Any:
        discriminator = through(switch.incoming, discriminator)
        branch = descriptor.branch(discriminator)
        if branch is not None:
            wire = wires[descriptor.branches.index(branch)]
            value = through(wire.incoming, value)
        return class_(discriminator, value)

    return make


def _union_outgoing(
    descriptor: UnionDescriptor, switch: WireType, wires: Sequence[WireType]
) -> Convert:
    def outgoing(union: Any) -> WireUnion:
        value = union.value
        branch = descriptor.branch(union.discriminator)
        if branch is not None:
            wire = wires[descriptor.branches.index(branch)]
            value = through(wire.outgoing, value)
        return WireUnion(through(switch.outgoing, union.discriminator), value)

    return outgoing


def _enum(descriptor: EnumDescriptor) -> WireType:
    class_ = class_of(descriptor)
    numbers = [number for _, number in descriptor.members]
    if class_ is None:
        return _dynamic_enum(descriptor, numbers)
    if numbers != list(range(len(numbers))):
        kind = tcInternal.tv_long if descriptor.code == "i" else tcInternal.tv_ulong
        return WireType(kind, int, class_)
    items = tuple(map(class_, numbers))
    # omniORBpy finds attributes of the class sooner than those of its items.
    class_._v, class_._parent_id = int.real, descriptor.repository_id
    for item, (name, _) in zip(items, descriptor.members, strict=True):
        item._n = name
    name = _last(descriptor.name)
    return WireType((tcInternal.tv_enum, descriptor.repository_id, name, items))


def _dynamic_enum(descriptor: EnumDescriptor, numbers: list[int]) -> WireType:
    """Return the type of an enum without a class, whose values are numbers."""
    kind = tcInternal.tv_long if descriptor.code == "i" else tcInternal.tv_ulong

    def checked(number: int) -> int:
        if number not in numbers:
            raise ValueError(f"{number!r} is not a member of {descriptor}")
        return number

    return WireType(kind, checked, checked)


def _fixed(digits: int, scale: int) -> WireType:
    unit = Decimal(1).scaleb(-scale)

    def outgoing(value: Any) -> Any:
        fixed_octets(value, digits, scale)
        return omniORB.fixed(digits, scale, f"{value:f}")

    def incoming(value: Any) -> Decimal:
        return Decimal(str(value)).quantize(unit, context=_DIGITS)

    return WireType((tcInternal.tv_fixed, digits, scale), outgoing, incoming)


def _label(switch: Descriptor, label: Any) -> Any:
    class_ = class_of(switch)
    return label if class_ is None else class_(label)


def _unused(switch: Descriptor, union: UnionDescriptor) -> Any:
    """Return a discriminator that selects the default branch."""
    used = {label for branch in union.branches for label in branch.labels}
    candidates: Iterable[Any] = range(len(used) + 1)
    if isinstance(switch, EnumDescriptor):
        candidates = class_of(switch) or candidates
    elif switch == _CHAR:
        candidates = map(chr, candidates)
    elif switch == PrimitiveDescriptor("boolean"):
        candidates = (False, True)
    return next(c for c in candidates if c not in used)


def _converted(descriptors: Iterable[Descriptor], seen: set[int]) -> bool:
    """Return whether values of these types are converted in either direction."""
    return any(_is_converted(descriptor, seen) for descriptor in descriptors)


def _is_converted(descriptor: Descriptor, seen: set[int]) -> bool:
    match plain(descriptor):
        case PrimitiveDescriptor(name):
            return name not in _PRIMITIVES
        case StringDescriptor():
            return False
        case EnumDescriptor(members=members, class_=class_):
            return class_ is None or any(
                i != number for i, (_, number) in enumerate(members)
            )
        case SequenceDescriptor(element, numeric=numeric) | ArrayDescriptor(
            element, numeric=numeric
        ):
            return numeric != "list" or _is_converted(element, seen)
        case StructDescriptor(members=parts) | UnionDescriptor(branches=parts) as whole:
            if id(whole) in seen:
                return False
            seen.add(id(whole))
            renamed = isinstance(whole, StructDescriptor) and any(
                part.attribute != part.name for part in parts
            )
            switches = isinstance(whole, UnionDescriptor) and _enum_without_class(whole)
            return renamed or switches or _converted((p.type for p in parts), seen)
    return True


def _enum_without_class(union: UnionDescriptor) -> bool:
    """Return whether the union switches on an enum without a class, whose values are checked."""
    switch = plain(union.switch)
    return isinstance(switch, EnumDescriptor) and switch.class_ is None


def _items(
    element: Descriptor, wire: WireType
) -> tuple[Convert | None, Convert | None]:
    """Return the conversions of the items of a sequence or array, outgoing and incoming."""
    if plain(element) == _CHAR:
        return latin_octets, latin_text
    if plain(element) == _INT8:
        return octets_of, each(int8_of)
    if is_octet(element):
        return octets, None
    return each(wire.outgoing), each(wire.incoming)


def _formed(
    descriptor: SequenceDescriptor | ArrayDescriptor,
    items: tuple[Convert | None, Convert | None],
) -> tuple[Convert | None, Convert | None]:
    """Return the conversions from numbers in any form, and to the form of the descriptor."""
    outgoing, incoming = items
    if descriptor.numeric == "list":
        if not is_in_buffers(descriptor.element):
            return items
        return lambda value: through(outgoing, listed(descriptor, value)), incoming
    return (
        lambda value: through(outgoing, listed(descriptor, value)),
        lambda wire: formed(descriptor, through(incoming, wire)),
    )


def _plain_copy(descriptor: StructDescriptor | UnionDescriptor) -> Convert | None:
    """Return the function that copies values which may hold buffers; None for other types."""
    class_ = class_of(descriptor)
    collections = (SequenceDescriptor, ArrayDescriptor)
    elements = [p.element for p in parts(descriptor) if isinstance(p, collections)]
    if class_ is None or not any(is_octet(e) or is_in_buffers(e) for e in elements):
        return None
    copy: Convert = class_._snapshot_
    return copy


def _last(name: str) -> str:
    return name.rpartition("::")[2]
