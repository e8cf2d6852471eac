"""Unmarshals classic CDR by descriptors: the inverse of `writer`.

Lengths are checked against the remaining octets, and created values are counted, so that memory and
time are bounded by the size of the input.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import prod
from typing import Any, TypeVar

from rtgen.runtime.marshalling.descriptors import (
    UNKNOWN,
    AliasDescriptor,
    ArrayDescriptor,
    BitsetDescriptor,
    BoxDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    FlagsDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    class_of,
    plain,
    registered,
)
from rtgen.runtime.marshalling.dynamic.checks import (
    CODES,
    TEXTS,
    LeastSizes,
    bits_code,
    check_bound,
    check_string,
)
from rtgen.runtime.marshalling.dynamic.direct import compiled_class
from rtgen.runtime.marshalling.dynamic.forms import formed
from rtgen.runtime.marshalling.dynamic.octet_reader import OctetReader
from rtgen.runtime.marshalling.dynamic.writer import (
    CHUNKED,
    CODEBASE,
    ID_LIST,
    INDIRECTION,
    NULL_TAG,
    ONE_ID,
    VALUE_TAG,
)
from rtgen.runtime.marshalling.errors import LOCATED, Buffer, Fault, located
from rtgen.runtime.marshalling.octets import (
    ObjectReference,
    fixed_value,
    quad_value,
    text_value,
    wide_character_value,
    wide_value,
)
from rtgen.runtime.marshalling.type_codes import simple_type, type_of_code

_T = TypeVar("_T")
_WITHOUT_CHUNKS = "a value without chunks inside of one that has them"
_MAX_IDS = 100


def read_dynamic(
    data: Buffer, offset: int, descriptor: Descriptor, little_endian: bool
) -> tuple[Any, int]:
    """Return the value of the descriptor at `offset`, and the next offset. Raises ValueError."""
    reader = Reader(data, little_endian, offset)
    return reader.value(descriptor), reader.offset


class Reader(OctetReader):
    """Reads consecutive values. Raises Fault for invalid input.

    `walking`: compiled codecs are not used, so that a fault has a complete path.
    """

    def __init__(
        self,
        data: Buffer,
        little_endian: bool,
        offset: int = 0,
        walking: bool = False,
    ) -> None:
        super().__init__(data, little_endian, offset)
        self._walking = walking
        self._sizes = LeastSizes()

    def value(self, descriptor: Descriptor) -> Any:
        """Return a value of any type."""
        self._data.work -= 1
        if self._data.work < 0:
            raise Fault("more values than the octets account for")
        match descriptor:
            case LinkDescriptor() | AliasDescriptor():
                return self.value(plain(descriptor))
            case PrimitiveDescriptor(name):
                return self._primitive(name)
            case StringDescriptor(wide, bound):
                octets = self._octets(self._count(1))
                text = (wide_value if wide else text_value)(octets)
                check_string(text, wide, bound)
                return text
            case FixedDescriptor(digits, scale):
                return fixed_value(self._take(digits // 2 + 1, 1), digits, scale)
            case EnumDescriptor():
                return self._enumerator(descriptor)
            case FlagsDescriptor() | BitsetDescriptor():
                return self._bits(descriptor)
            case SequenceDescriptor(element, bound):
                return formed(descriptor, self._sequence(element, bound))
            case ArrayDescriptor(element, dimensions):
                if not self._sizes.of(element):
                    self._data.work -= prod(dimensions)
                return formed(descriptor, self._array(element, dimensions))
            case MapDescriptor(key, item, bound):
                return self._map(key, item, bound)
            case StructDescriptor() | UnionDescriptor():
                class_ = None if self._walking else compiled_class(descriptor)
                if class_ is not None and not self._level:
                    read = class_._read_
                    value, self.offset = read(self._data, self.offset, self._little)
                    return value
                if isinstance(descriptor, UnionDescriptor):
                    return self._union(descriptor)
                return self._struct(descriptor)
            case ExceptionDescriptor():
                return self._struct(descriptor)
            case InterfaceDescriptor(abstract=True):
                return self._reference() if self._boolean() else self._valued(None)
            case InterfaceDescriptor():
                return self._reference()
            case ValueDescriptor() | BoxDescriptor():
                return self._valued(descriptor)

    # Basic types.

    def _primitive(self, name: str) -> Any:
        match name:
            case "boolean":
                return self._boolean()
            case "char":
                return self._take(1, 1).decode("latin-1")
            case "wchar":
                return wide_character_value(self._take(3, 1))
            case "long double":
                return quad_value(self._take(16, 8), self._little)
            case "Object":
                return self._reference()
            case "any":
                return self.any()
            case "CORBA::TypeCode":
                return self._type_code()
            case "ValueBase":
                return self._valued(None)
            case "null" | "void":
                return None
        return self._number(CODES[name])

    def _boolean(self) -> bool:
        octet = self._take(1, 1)[0]
        if octet > 1:
            raise Fault(f"{octet} is not a boolean")
        return bool(octet)

    def _enumerator(self, descriptor: EnumDescriptor) -> Any:
        number = self._integer(descriptor.code)
        if number not in [n for _, n in descriptor.members]:
            raise Fault(f"{number} is not a member of {descriptor.name}")
        class_ = class_of(descriptor)
        return number if class_ is None else class_(number)

    def _bits(self, descriptor: FlagsDescriptor | BitsetDescriptor) -> Any:
        number = self._integer(bits_code(descriptor.bound))
        if number >> descriptor.bound:
            raise Fault(f"{number} has more than {descriptor.bound} bits")
        class_ = class_of(descriptor)
        return number if class_ is None else class_.from_number(number)

    # Collections.

    def _sequence(self, element: Descriptor, bound: int | None) -> Any:
        count = self._count(self._sizes.of(element) or 1)
        check_bound(count, bound, "items")
        return self._items(element, count)

    def _items(self, element: Descriptor, count: int) -> Any:
        inner = plain(element)
        name = inner.name if isinstance(inner, PrimitiveDescriptor) else ""
        if name in TEXTS:
            octets = self._octets(count)
            return octets.decode("latin-1") if name == "char" else octets
        return self._repeated(count, partial(self.value, element))

    def _repeated(self, count: int, read: Callable[[], Any]) -> list[Any]:
        items: list[Any] = []
        try:
            for _ in range(count):
                items.append(read())
        except LOCATED as failure:
            raise located(failure, f"[{len(items)}]") from failure
        return items

    def _array(self, element: Descriptor, dimensions: tuple[int, ...]) -> Any:
        if len(dimensions) == 1:
            return self._items(element, dimensions[0])
        return self._repeated(
            dimensions[0], partial(self._array, element, dimensions[1:])
        )

    def _map(self, key: Descriptor, item: Descriptor, bound: int | None) -> Any:
        count = self._count(1)
        check_bound(count, bound, "items")
        entries: dict[Any, Any] = {}
        try:
            for _ in range(count):
                k = self.value(key)
                entries[k] = self.value(item)
        except LOCATED as failure:
            raise located(failure, f"[{len(entries)}]") from failure
        if len(entries) != count:
            raise Fault("a key that is there twice")
        return entries

    # Constructed types.

    def _struct(self, descriptor: StructDescriptor | ExceptionDescriptor) -> Any:
        values: list[Any] = []
        part = ""
        try:
            for member in descriptor.members:
                part = f".{member.name}"
                values.append(self.value(member.type))
        except LOCATED as failure:
            raise located(failure, part) from failure
        class_ = class_of(descriptor)
        if class_ is not None:
            return class_(*values)
        names = [member.name for member in descriptor.members]
        members = dict(zip(names, values, strict=True))
        return UNKNOWN[StructDescriptor](descriptor, members)

    def _union(self, descriptor: UnionDescriptor) -> Any:
        part = ".discriminator"
        value = None
        try:
            discriminator = self.value(descriptor.switch)
            branch = descriptor.branch(discriminator)
            if branch is not None:
                part = f".{branch.name}"
                value = self.value(branch.type)
        except LOCATED as failure:
            raise located(failure, part) from failure
        class_ = class_of(descriptor) or partial(UNKNOWN[UnionDescriptor], descriptor)
        return class_(discriminator, value)

    def _reference(self) -> ObjectReference | None:
        type_id = self._text()
        profiles = []
        for _ in range(self._count(8)):
            tag = self._integer("I")
            profiles.append((tag, bytes(self._octets(self._count(1)))))
        return ObjectReference(type_id, tuple(profiles)) if profiles else None

    def _text(self) -> str:
        return text_value(self._octets(self._count(1)))

    # Any and type codes.

    def any(self) -> Any:
        """Return an `any`."""
        type_ = self._type_code()
        described = plain(type_)
        try:
            if isinstance(described, ExceptionDescriptor):
                repository_id = self._text()
                if repository_id != described.repository_id:
                    raise Fault(f"{repository_id} instead of {described.repository_id}")
            return UNKNOWN[PrimitiveDescriptor](type_, self.value(described))
        except LOCATED as failure:
            raise located(failure, ".value") from failure

    def _type_code(self) -> Descriptor:
        kind = self._integer("I")
        simple = simple_type(kind, self._integer)
        if simple is not None:
            return simple
        return type_of_code(kind, self._octets(self._count(1)))

    # Values (CORBA 3.3 part 2, 9.3.4).

    def _valued(self, formal: ValueDescriptor | BoxDescriptor | None) -> Any:
        start = -1
        if self._level and self.offset >= self._chunk_end:
            tag, start = self._tag_between_chunks()
        inside = start < 0
        if inside:
            tag = self._integer("I")
            start = self.offset - 4
        if tag == NULL_TAG:
            return None
        if tag == INDIRECTION:
            place = self.offset + -self.offset % 4
            return self._shared(place + self._integer("i"), formal)
        if not VALUE_TAG <= tag < 0x80000000 or (self._level and inside):
            raise Fault(f"{tag:#x} does not begin a value")
        ids = self._header(tag)
        chunked = bool(tag & CHUNKED)
        if self._level and not chunked:
            raise Fault(_WITHOUT_CHUNKS)
        actual, truncated = self._actual(formal, ids)
        if truncated and not chunked:
            raise Fault(f"{ids[0]} is not known, and has no chunks")
        return self._state(actual, start, chunked, truncated)

    def _tag_between_chunks(self) -> tuple[int, int]:
        """Return the tag of a header between chunks, and its offset; (0, -1) if a chunk follows."""
        before = self.offset
        tag = self._between("I")
        if tag == NULL_TAG or VALUE_TAG <= tag < 0x80000000:
            return tag, self.offset - 4
        self.offset = before
        return 0, -1

    def _header(self, tag: int) -> list[str]:
        """Return the repository ids after a tag, the most derived first."""
        level, self._level = self._level, 0
        if tag & CODEBASE:
            self._id()
        ids: list[str] = []
        if tag & ID_LIST == ID_LIST:
            ids = self._ids()
        elif tag & ONE_ID:
            ids = [self._id()]
        self._level = level
        self._chunk_end = self.offset
        return ids

    def _ids(self) -> list[str]:
        return self._redirected(self._id_list)

    def _id_list(self) -> list[str]:
        count = self._count(4)
        check_bound(count, _MAX_IDS, "repository ids")
        return [self._id() for _ in range(count)]

    def _id(self) -> str:
        return self._redirected(self._text)

    def _redirected(self, read: Callable[[], _T]) -> _T:
        """Return the result of `read` here, or at the earlier offset of an indirection."""
        before = self.offset
        if self._integer("I") != INDIRECTION:
            self.offset = before
            return read()
        here = self.offset
        place = here + self._integer("i")
        after = self.offset
        if not 0 <= place < before:
            raise Fault("an indirection to no repository id")
        self.offset = place
        value = read()
        self.offset = after
        return value

    def _shared(
        self, place: int, formal: ValueDescriptor | BoxDescriptor | None
    ) -> Any:
        if place not in self._data.values:
            raise Fault("an indirection to no value")
        value = self._data.values[place]
        self._fits(formal, value.described())
        return value

    def _fits(
        self, formal: ValueDescriptor | BoxDescriptor | None, actual: Any
    ) -> None:
        if formal is not None and not actual.is_a(formal.repository_id):
            raise Fault(f"a {formal.name} is needed, not a {actual.name}")

    def _actual(
        self, formal: ValueDescriptor | BoxDescriptor | None, ids: list[str]
    ) -> tuple[ValueDescriptor | BoxDescriptor, bool]:
        """Return the type of the created value, and whether it truncates the state."""
        if not ids:
            if formal is None:
                raise Fault("a value without its type")
            return formal, False
        for index, repository_id in enumerate(ids):
            actual = registered(repository_id)
            if formal is not None and repository_id == formal.repository_id:
                actual = formal
            if isinstance(actual, ValueDescriptor | BoxDescriptor):
                self._fits(formal, actual)
                return actual, index > 0
        raise Fault(f"{ids[0]} is not known")

    def _state(
        self,
        actual: ValueDescriptor | BoxDescriptor,
        place: int,
        chunked: bool,
        truncated: bool,
    ) -> Any:
        self._level += chunked
        self._chunk_end = self.offset
        state: Any
        if isinstance(actual, BoxDescriptor):
            state = _empty(actual)
            self._data.values[place] = state
            try:
                state.value = self.value(actual.target)
            except LOCATED as failure:
                raise located(failure, ".value") from failure
        else:
            state = self._members(actual, place)
        if chunked:
            self._end_value(truncated)
        return state

    def _members(self, actual: ValueDescriptor, place: int) -> Any:
        if actual.modifier in ("abstract", "custom"):
            raise Fault(f"{actual.name} is {actual.modifier}: it has no state here")
        class_ = class_of(actual)
        state = _empty(actual)
        self._data.values[place] = state
        part = ""
        try:
            for member in actual.all_members():
                part = f".{member.name}"
                inner = self.value(member.type)
                if class_ is None:
                    state.members[member.name] = inner
                else:
                    setattr(state, member.attribute, inner)
        except LOCATED as failure:
            raise located(failure, part) from failure
        return state

    def _end_value(self, truncated: bool) -> None:
        """Read the end tag, which may also close enclosing values."""
        if not self._closed:
            if self.offset < self._chunk_end and not truncated:
                raise Fault(
                    f"{self._chunk_end - self.offset} octets too many in a chunk"
                )
            self.offset = self._chunk_end
            level = self._level
            while True:
                tag = self._between("i")
                if tag < 0:
                    if -tag > level:
                        raise Fault(f"an end tag {tag} at level {level}")
                    level = -tag - 1
                    if level < self._level:
                        break
                elif not truncated or not tag:
                    raise Fault("a value continues after the end of its state")
                elif tag < VALUE_TAG:
                    self._skip(tag)
                elif not tag & CHUNKED:
                    raise Fault(_WITHOUT_CHUNKS)
                else:
                    self._header(tag)
                    level += 1
            self._closed = level + 1
        if self._closed == self._level:
            self._closed = 0
        self._level -= 1
        self._chunk_end = self.offset


def _empty(descriptor: ValueDescriptor | BoxDescriptor) -> Any:
    """Return a value without state, to which its state may refer."""
    class_ = class_of(descriptor)
    if class_ is None:
        return UNKNOWN[type(descriptor)](descriptor)
    return class_.__new__(class_)
