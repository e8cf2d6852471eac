"""Changes between two versions of definitions: their kinds, what they break, and for whom."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from rtgen.compiler.diagnostics import Rule, Severity

if TYPE_CHECKING:
    from rtgen.compiler.diagnostics import Span


class Break(StrEnum):
    """Classes of changes; a change that breaks nothing is compatible."""

    WIRE = "wire"
    SOURCE = "source"
    STORED = "stored"
    COMPATIBLE = "compatible"


BREAKING = (Break.WIRE, Break.SOURCE, Break.STORED)
"""The classes of breaking changes."""


class Wire(StrEnum):
    """What a change of the class `wire` breaks: an encoding, or how peers find each other."""

    CDR = "CDR"
    XCDR1 = "XCDR1"
    XCDR2 = "XCDR2"
    KEY = "key hash"
    GIOP = "GIOP"
    TDR = "TDR"
    FUNCTION_ID = "function id"
    PDO = "PDO"
    COB_ID = "COB-ID"
    TRANSMISSION = "PDO transmission"
    SDO = "SDO"
    NODE = "node control"


LOGGED = frozenset((Wire.CDR, Wire.XCDR1, Wire.XCDR2, Wire.PDO))
"""The encodings in logs."""

_ORDER = {wire: number for number, wire in enumerate(Wire)}


def in_wire_order(wires: Iterable[Wire]) -> tuple[Wire, ...]:
    """Return the wires in the order of `Wire`, without duplicates."""
    return tuple(sorted(set(wires), key=_ORDER.__getitem__))


class Kind(NamedTuple):
    """A kind of change: the record behind its rule, its row in docs/changes.md and its messages.

    `breaks` are the classes of each change of the kind, `wires` what each breaks on the wire; kinds
    of types leave both to the comparison, which knows the extensibility.
    """

    code: str
    title: str
    breaks: tuple[Break, ...]
    wires: tuple[Wire, ...] = ()

    @property
    def rule(self) -> Rule:
        """The rule of `rtgen explain`; its severity is that of a change of a selected class."""
        return Rule(self.code, self.title, Severity.ERROR)

    @property
    def why(self) -> str:
        """The reason for `breaks`: the first sentence of the rule's page, as part of another."""
        sentence = " ".join(self.rule.explanation.partition("\n\n")[0].split())
        name = sentence.partition(" ")[0]
        start = name if name != name.capitalize() else name.lower()
        return start + sentence.removeprefix(name).removesuffix(".")


def kinds_of(names: Mapping[str, object]) -> tuple[Kind, ...]:
    """Return the kinds among the `globals()` of a module, in order."""
    return tuple(value for value in names.values() if isinstance(value, Kind))


class User(NamedTuple):
    """Part of the project that a change breaks: `kind` is `port`, `connection`, `node`, ..."""

    kind: str
    name: str
    wires: tuple[Wire, ...] = ()


class Change(NamedTuple):
    """A change of `subject`, a scoped name; `old` and `new` are its places, None if missing."""

    kind: Kind
    subject: str
    message: str
    old: Span | None
    new: Span | None
    wires: tuple[Wire, ...] = ()
    breaks: tuple[Break, ...] = ()
    users: tuple[User, ...] = ()

    @property
    def classes(self) -> tuple[Break, ...]:
        """The classes of the kind, and those implied by the wires.

        Logs contain samples in CDR and frames of PDOs, so what breaks these also breaks stored
        data.
        """
        found = {*self.breaks, *([Break.WIRE] if self.wires else [])}
        if not LOGGED.isdisjoint(self.wires):
            found.add(Break.STORED)
        return tuple(b for b in BREAKING if b in found) or (Break.COMPATIBLE,)


def change(
    kind: Kind,
    subject: str,
    message: str,
    old: Span | None,
    new: Span | None,
    *,
    wires: Iterable[Wire] | None = None,
    breaks: Iterable[Break] | None = None,
) -> Change:
    """Return a change; classes and wires default to those of its kind."""
    return Change(
        kind=kind,
        subject=subject,
        message=message,
        old=old,
        new=new,
        wires=in_wire_order(kind.wires if wires is None else wires),
        breaks=tuple(kind.breaks if breaks is None else breaks),
    )
