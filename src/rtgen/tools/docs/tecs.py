"""Pages of TECS signatures: functions with their ids, and the bytes of requests and replies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rtgen.compiler.backends.kit.quoting.markdown import code
from rtgen.compiler.inspection.tecs import prototype
from rtgen.compiler.layouts.tdr import (
    Branch,
    Counted,
    Field,
    FixedArray,
    FunctionLayout,
    Item,
    Node,
    Octets,
    Part,
    Payload,
    Record,
    Reserve,
    Role,
    Run,
    Step,
    String,
    TransferError,
    size_of,
)
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.model import ScopedName
from rtgen.compiler.model.tecs import Celltype, Signature, TecsUnit
from rtgen.tools.docs.pages import Content, Page
from rtgen.tools.docs.places import Kind


class Documented(NamedTuple):
    """A signature with its unit, and celltypes by the kind and the signature of their ports."""

    unit: TecsUnit
    signature: Signature
    users: Mapping[tuple[str, ScopedName], Sequence[str]]


def listed(content: Content) -> Mapping[str, Documented]:
    """Return the signatures by name, and assign pages to them."""
    found: dict[str, Documented] = {}
    for unit in content.model.tecs:
        users: dict[tuple[str, ScopedName], list[str]] = {}
        for declaration in unit.declarations:
            match declaration:
                case Signature():
                    documented = Documented(unit, declaration, users)
                    found.setdefault(declaration.scoped, documented)
                case Celltype(ports=ports):
                    for key in {(p.kind, p.signature): None for p in ports}:
                        users.setdefault(key, []).append(declaration.scoped)
    return content.assign(Kind.SIGNATURE, found)


def add(content: Content, page: Page, documented: Documented) -> None:
    """Fill the page of a signature."""
    unit, s, users = documented
    page.description(s.doc)
    page.add(f"Defined in {content.source(s.file, s.span)}.")
    for kind, verb in (("entry", "Provided by"), ("call", "Called by")):
        celltypes = users.get((kind, s.name))
        if celltypes:
            page.add(f"{verb} the celltypes {', '.join(map(code, celltypes))}.")
    page.heading(2, "Functions")
    rows = [(f.id, code(prototype(f)), "oneway" * f.oneway, f.doc) for f in s.functions]
    page.table(("id", "function", "", "description"), rows)
    try:
        layout = layout_of(unit, s)
    except TransferError as error:
        page.add(f"OpaqueRPC cannot carry this signature: {code(error.reason)}.")
        return
    page.heading(2, "Messages")
    page.add(
        "Octets of OpaqueRPC, in the order of the line; offsets and sizes are those of TDR "
        "`network` (big endian; short 16, int, long and intptr_t 32 bits)."
    )
    for function in layout.functions:
        _add_messages(page, function)


def _add_messages(page: Page, f: FunctionLayout) -> None:
    page.heading(3, f"{f.function.id} {f.function.name}", f"f{f.function.id}")
    for name, steps in (("Request", f.request), ("Reply", f.reply)):
        if steps is None:
            page.add("No reply: the call is oneway.")
            continue
        rows = [*_Table(f.function.id).rows(steps)]
        page.add(f"{name}:")
        page.table(("offset", "octets", "content", "when"), rows)


class _Table:
    """Rows of a message; offsets are known up to the first value of variable size."""

    def __init__(self, number: int) -> None:
        self._number = number
        self._offset: int | None = 0

    def rows(
        self, steps: Sequence[Step], when: str = "", prefix: str = ""
    ) -> Iterator[tuple[object, ...]]:
        for step in steps:
            match step:
                case Run(fields):
                    for field in fields:
                        yield from self._field(field, when, prefix)
                case Payload(item):
                    yield self._row(None, self._payload(item, prefix), when)
                case Part(item):
                    yield from self._part(item, when, prefix)
                case Branch(item, inner):
                    some = f"{prefix}{item.name} is not NULL"
                    yield from self.rows(
                        inner, f"{when}, {some}" if when else some, prefix
                    )
                    self._offset = None
                case Reserve():
                    pass

    def _field(
        self, field: Field, when: str, prefix: str
    ) -> Iterator[tuple[object, ...]]:
        item = field.item
        name = "" if item is None else prefix + (item.name or "return value")
        match field.role:
            case Role.SOP:
                yield self._row(2, "start of the message", when)
            case Role.ID:
                yield self._row(2, f"function id {self._number}", when)
            case Role.EOP:
                yield self._row(2, "end of the message", when)
            case Role.FLAG:
                yield self._row(1, f"flag of {name}", when)
            case Role.LENGTH:
                yield self._row(4, f"length of {name}", when)
            case Role.VALUE:
                assert item is not None
                yield self._row(size_of(item.node), f"{name}: {_type(item.node)}", when)

    def _part(self, item: Item, when: str, prefix: str) -> Iterator[tuple[object, ...]]:
        name = prefix + item.name
        match item.node:
            case Record(_, _, steps):
                yield from self.rows(steps, when, f"{name}.")
            case Counted(Record(_, _, steps)) | FixedArray(Record(_, _, steps)):
                yield from self.rows(
                    steps, f"{when} for each element".strip(), f"{name}[]."
                )
                self._offset = None
            case node:
                yield self._row(None, f"{name}: {_type(node)}", when)

    def _payload(self, item: Item, prefix: str) -> str:
        return f"{prefix}{item.name}: {_type(item.node)}"

    def _row(self, size: int | None, what: str, when: str) -> tuple[object, ...]:
        start = self._offset
        self._offset = None if start is None or size is None else start + size
        return (
            "..." if start is None else start,
            "..." if size is None else size,
            what,
            when,
        )


def _type(node: Node) -> str:
    match node:
        case Octets(scalar, count):
            return f"{scalar}[{count}]"
        case FixedArray(element, count):
            return f"{_type(element)}[{count}]"
        case Record(struct):
            return f"struct {struct.scoped}"
        case Counted(element):
            return f"elements of {_type(element)}"
        case String(scalar):
            return f"characters of {scalar}"
    return str(getattr(node, "scalar", "nothing"))
