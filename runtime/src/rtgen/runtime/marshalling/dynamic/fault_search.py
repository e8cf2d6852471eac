"""Locates an error in octets of XCDR that could not be decoded, by reading along the layout.

Values are read one by one as compiled codecs do, with the path of each. Delimited content is cut
out of the data and read from offset 0: it starts at a multiple of 4, and nothing in it has a larger
alignment.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from itertools import product
from typing import Any, TypeAlias

from rtgen.runtime.marshalling.descriptors import StructDescriptor, UnionDescriptor
from rtgen.runtime.marshalling.errors import LOCATED, Fault, located
from rtgen.runtime.marshalling.layouts.formats import Format
from rtgen.runtime.marshalling.layouts.headers import left, next_member, next_parameter
from rtgen.runtime.marshalling.layouts.nodes import (
    Atom,
    AtomArray,
    AtomSequence,
    Call,
    Delimited,
    Form,
    Group,
    Member,
    MemberList,
    Node,
    Optional,
    Parameter,
    Records,
    Repeat,
    Text,
    TextArray,
    TextSequence,
    minimum_size,
)
from rtgen.runtime.marshalling.layouts.trees import (
    DISCRIMINATOR,
    body_of,
    has_list,
    is_delimited,
    tree_of,
    union_members,
)
from rtgen.runtime.marshalling.source.conversions import Conversions
from rtgen.runtime.marshalling.source.decoder import EMPTY_ELEMENTS
from rtgen.runtime.marshalling.source.text import Namespace

Octets: TypeAlias = bytes | memoryview
_Members: TypeAlias = Iterable[tuple[str, Member | Parameter]]


def fault_in_body(
    descriptor: Any,
    data: Octets,
    format_: Format,
    little_endian: bool,
    *,
    exact: bool = True,
) -> Fault | None:
    """Return the first error of a body; None if there is none, or if it is nested too deep to be
    found: the search needs more of the stack than a codec.

    Not `exact`: octets after the value are no error.
    """
    search = _Search(format_, little_endian)
    try:
        extensibility = getattr(descriptor, "extensibility", "")
        if (
            isinstance(descriptor, StructDescriptor)
            and extensibility == "appendable"
            and format_.version == 1
        ):
            search.members(descriptor, data, 0, evolving=True)
            return None
        _, offset = search.whole(descriptor, data)
        if exact and offset != len(data):
            raise Fault(f"{len(data) - offset} octets too many")
    except LOCATED as failure:
        return _extended(failure, "")
    except RecursionError:
        return None
    return None


class _Search:
    """Reads values of a format; raises an exception of LOCATED, or Fault with the path."""

    def __init__(self, format_: Format, little_endian: bool) -> None:
        self._format = format_
        self._little = bool(little_endian)
        self._order = "<" if little_endian else ">"
        self._namespace = Namespace()
        self._convert = Conversions(self._namespace)
        self._conversions: dict[str, Callable[[Any, bool], Any]] = {}

    def whole(self, descriptor: Any, data: Octets) -> tuple[Any, int]:
        """Return the value of a type at the start of the data."""
        if isinstance(descriptor, StructDescriptor | UnionDescriptor):
            return self.declared(descriptor, data, 0)
        return self.read(tree_of(descriptor, self._format), data, 0)

    def declared(self, descriptor: Any, data: Octets, offset: int) -> tuple[Any, int]:
        """Return a struct or union."""
        union = isinstance(descriptor, UnionDescriptor)
        read = self._union if union else self.members
        if not is_delimited(descriptor, self._format):
            return None, read(descriptor, data, offset, False)
        evolving = descriptor.extensibility == "appendable"
        return self._delimited(
            data,
            offset,
            lambda content: (None, read(descriptor, content, 0, evolving)),
        )

    def members(
        self, descriptor: Any, data: Octets, offset: int, evolving: bool
    ) -> int:
        """Read a struct's members; `evolving`: it can end early, and extra octets are ignored."""
        body = self._body(descriptor)
        names = {m.attribute: m.name for m in descriptor.members}
        if isinstance(body, MemberList):
            names_read, offset = self._list(body.members, names, data, offset)
            for attribute, member in body.members:
                if member.key and attribute not in names_read:
                    raise located(Fault("a key is missing"), f".{names[attribute]}")
            return offset
        for attribute, node in body.members:
            if evolving and offset >= len(data):
                break
            _, offset = self._part(f".{names[attribute]}", node, data, offset)
        return len(data) if evolving else offset

    def _body(self, descriptor: Any) -> Group | MemberList:
        """Return the members of a struct, kept with its codecs."""
        key = ("body", self._format)
        if key not in descriptor.codecs:
            descriptor.codecs[key] = body_of(descriptor, self._format)
        body: Group | MemberList = descriptor.codecs[key]
        return body

    def _part(
        self, part: str, node: Node, data: Octets, offset: int
    ) -> tuple[Any, int]:
        try:
            return self.read(node, data, offset)
        except LOCATED as failure:
            raise _extended(failure, part) from failure

    def read(self, node: Node, data: Octets, offset: int) -> tuple[Any, int]:
        """Return the value of a node that is an atom or text, and the next offset."""
        match node:
            case Atom():
                return self._atom(node, data, offset)
            case AtomArray(atom=atom, dimensions=dimensions):
                left(len(data), offset, minimum_size(node))
                indices = product(*map(range, dimensions))
                parts = ("".join(f"[{i}]" for i in index) for index in indices)
                return None, self._items(parts, atom, data, offset)
            case TextArray(text=text, length=length):
                left(len(data), offset, length)
                return self._text(text, data, offset, length, None)
            case AtomSequence(atom=atom, bound=bound):
                count, offset = self._count(data, offset, atom.size, bound)
                if atom.form is Form.WORD:
                    raw = struct.unpack_from(f"{self._order}{count}I", data, offset)
                    text = self._converted(self._convert.worded("raw"), raw)
                    return text, offset + count * atom.size
                return None, self._items(_numbers(count), atom, data, offset)
            case TextSequence():
                return self._string(node, data, offset)
            case Records(element, length=length, bound=bound):
                return self._repeated(
                    element, length, bound, node.size, None, data, offset
                )
            case Repeat(element, minimum, bound, length, key):
                return self._repeated(
                    element, length, bound, minimum, key, data, offset
                )
            case Group(type=type_):
                return None, self.members(type_, data, offset, False)
            case Call(type=type_):
                return self.declared(type_, data, offset)
            case Delimited(node=inner):
                return self._delimited(
                    data, offset, lambda content: self.read(inner, content, 0)
                )
            case Optional(node=inner):
                left(len(data), offset, 1)
                if data[offset] > 1:
                    raise Fault(f"{data[offset]} is not a boolean")
                return (
                    self.read(inner, data, offset + 1)
                    if data[offset]
                    else (None, offset + 1)
                )
            case Parameter(node=inner, id=id_):
                member_id, _, start, stop = next_parameter(data, offset, self._little)
                if member_id != id_:
                    raise Fault(f"the parameter {id_} is needed")
                if start != stop:
                    self._read_whole(inner, memoryview(data)[start:stop], 0)
                return None, stop
        raise TypeError(node)

    def _atom(self, atom: Atom, data: Octets, offset: int) -> tuple[Any, int]:
        offset += -offset % atom.align
        left(len(data), offset, atom.size)
        (raw,) = struct.unpack_from(self._order + atom.code, data, offset)
        value = self._converted(self._convert.unpacked(atom, "raw"), raw)
        return value, offset + atom.size

    def _converted(self, expression: str, raw: Any) -> Any:
        """Return the value of an expression from `Conversions` for `raw`."""
        if expression not in self._conversions:
            text = f"lambda raw, little_endian: {expression}"
            self._conversions[expression] = eval(text, self._namespace.values)
        return self._conversions[expression](raw, self._little)

    def _items(
        self, parts: Iterable[str], node: Node, data: Octets, offset: int
    ) -> int:
        for part in parts:
            _, offset = self._part(part, node, data, offset)
        return offset

    def _number(self, data: Octets, offset: int) -> tuple[int, int]:
        offset += -offset & 3
        left(len(data), offset, 4)
        (number,) = struct.unpack_from(f"{self._order}I", data, offset)
        return number, offset + 4

    def _count(
        self, data: Octets, offset: int, minimum: int, bound: int | None
    ) -> tuple[int, int]:
        count, offset = self._number(data, offset)
        rest = len(data) - offset
        if count * minimum > rest or (not minimum and count > EMPTY_ELEMENTS):
            raise Fault(f"a length of {count}, and {rest} octets are left")
        if bound is not None and count > bound:
            raise Fault(f"{count} items, and {bound} are the most")
        return count, offset

    def _string(self, node: TextSequence, data: Octets, offset: int) -> tuple[Any, int]:
        if node.text in (Text.OCTETS, Text.CHARACTERS):
            size, offset = self._count(data, offset, 1, node.bound)
            return self._text(node.text, data, offset, size, None)
        size, offset = self._number(data, offset)
        left(len(data), offset, size)
        wide = node.text is Text.UNITS
        length = size // 2 if wide else size - 1
        if node.bound is not None and length > node.bound:
            unit = "UTF-16 units" if wide else "octets of UTF-8"
            raise Fault(f"{length} {unit}, and {node.bound} are the most")
        return self._text(node.text, data, offset, size, node.bound)

    def _text(
        self, text: Text, data: Octets, offset: int, size: int, bound: int | None
    ) -> tuple[Any, int]:
        raw = bytes(data[offset : offset + size])
        expression = self._convert.unpacked_text(text, "raw", bound)
        return self._converted(expression, raw), offset + size

    def _repeated(
        self,
        element: Node,
        length: int | None,
        bound: int | None,
        minimum: int,
        key: Node | None,
        data: Octets,
        offset: int,
    ) -> tuple[Any, int]:
        count = length
        if count is None:
            count, offset = self._count(data, offset, minimum, bound)
        else:
            left(len(data), offset, count * minimum)
        if key is None:
            return None, self._items(_numbers(count), element, data, offset)
        keys = set()
        for part in _numbers(count):
            value, offset = self._part(part, key, data, offset)
            keys.add(value)
            _, offset = self._part(part, element, data, offset)
        if len(keys) != count:
            raise Fault("a key that is there twice")
        return None, offset

    def _delimited(
        self,
        data: Octets,
        offset: int,
        read: Callable[[Octets], tuple[Any, int]],
    ) -> tuple[Any, int]:
        size, offset = self._number(data, offset)
        left(len(data), offset, size)
        value, used = read(memoryview(data)[offset : offset + size])
        if used != size:
            raise Fault(f"{size - used} octets too many")
        return value, offset + size

    def _union(
        self, descriptor: UnionDescriptor, data: Octets, offset: int, evolving: bool
    ) -> int:
        if has_list(descriptor, self._format):
            names = {b.attribute: b.name for b in descriptor.branches}
            names[DISCRIMINATOR] = DISCRIMINATOR
            members = union_members(descriptor, self._format)
            found, offset = self._list(members, names, data, offset)
            if DISCRIMINATOR not in found:
                raise Fault("the discriminator is missing")
            return offset
        switch = tree_of(descriptor.switch, self._format)
        selected, offset = self._part(f".{DISCRIMINATOR}", switch, data, offset)
        branch = descriptor.branch(selected)
        if branch is not None and not (evolving and offset >= len(data)):
            node = tree_of(branch.type, self._format)
            _, offset = self._part(f".{branch.name}", node, data, offset)
        return len(data) if evolving else offset

    def _list(
        self, members: _Members, names: dict[str, str], data: Octets, offset: int
    ) -> tuple[set[str], int]:
        """Return the attributes of the members in a list, and the next offset."""
        by_id = {member.id: (attribute, member) for attribute, member in members}
        names_read: set[str] = set()
        while self._format.version == 1 or offset < len(data):
            if self._format.version == 1:
                id_, required, start, offset = next_parameter(
                    data, offset, self._little
                )
                if id_ < 0:
                    break
            else:
                id_, required, start, offset = next_member(
                    data, offset, len(data), self._little
                )
            if id_ not in by_id:
                if required:
                    raise Fault(f"the unknown member {id_} has to be understood")
                continue
            attribute, member = by_id[id_]
            part = f".{names[attribute]}"
            if attribute in names_read:
                raise located(Fault("the member stands twice"), part)
            names_read.add(attribute)
            padding = 3 if isinstance(member, Parameter) else 0
            try:
                self._read_whole(member.node, memoryview(data)[start:offset], padding)
            except LOCATED as failure:
                raise _extended(failure, part) from failure
        return names_read, offset

    def _read_whole(self, node: Node, content: Octets, padding: int) -> None:
        """Read a value that fills the content, except for up to `padding` octets."""
        _, used = self.read(node, content, 0)
        if len(content) - used > padding:
            raise Fault(f"{len(content) - used} octets too many")


def _numbers(count: int) -> Iterable[str]:
    return (f"[{i}]" for i in range(count))


def _extended(failure: Exception, part: str) -> Fault:
    """Return the failure as a fault, with its path extended by one part."""
    if isinstance(failure, struct.error):
        failure = Fault("truncated")
    elif isinstance(failure, KeyError):
        failure = Fault(f"{failure.args[0]!r} is not one of its values")
    return located(failure, part)
