"""Messages and signals as a DBC file describes them, and the text of such a file.

Source: the published grammar of DBC files (Vector, DBC File Format Documentation, version 1.0).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

ENCODING = "latin-1"
"""The part that the encodings of DBC readers have in common: CP1252, Latin-1."""
NOBODY = "Vector__XXX"
"""The receiver of a message that no node of the file receives."""
MAX_NAME = 32
"""Characters of a name; longer ones are in attributes (System...LongSymbol)."""

_EXTENDED = 1 << 31
_KEYWORDS = frozenset({
    "VERSION", "NS_", "BS_", "BU_", "BO_", "SG_", "EV_", "CM_", "BA_", "VAL_", "CAT_", "FILTER",
    "VAL_TABLE_", "BO_TX_BU_", "ENVVAR_DATA_", "SGTYPE_", "SIG_GROUP_", "BA_DEF_", "BA_DEF_DEF_",
    "BA_DEF_REL_", "BA_REL_", "BA_DEF_DEF_REL_", "BU_SG_REL_", "BU_EV_REL_", "BU_BO_REL_",
    "CAT_DEF_", "SIG_VALTYPE_", "SIGTYPE_VALTYPE_", "SG_MUL_VAL_",
    "INT", "HEX", "FLOAT", "STRING", "ENUM",
})  # fmt: skip
_HEAD = """VERSION ""

NS_ :

BS_:
"""
_DEFINITIONS = """BA_DEF_ "BusType" STRING ;
BA_DEF_ "Baudrate" INT 0 1000000;
BA_DEF_ BU_ "SystemNodeLongSymbol" STRING ;
BA_DEF_ BO_ "SystemMessageLongSymbol" STRING ;
BA_DEF_ SG_ "SystemSignalLongSymbol" STRING ;
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 3600000;
BA_DEF_DEF_ "BusType" "";
BA_DEF_DEF_ "Baudrate" 0;
BA_DEF_DEF_ "SystemNodeLongSymbol" "";
BA_DEF_DEF_ "SystemMessageLongSymbol" "";
BA_DEF_DEF_ "SystemSignalLongSymbol" "";
BA_DEF_DEF_ "GenMsgCycleTime" 0;
BA_ "BusType" "CAN";
"""


@dataclass(frozen=True, slots=True)
class Signal:
    """A value in a message, little endian; `first` is its first bit.

    Physical value = `factor` * value; `low` and `high` are limits of the physical value. A `real`
    has 32 or 64 bits. `values` names values. A signal with a `selector` is there when that signal
    has one of the values in `when`, given as ranges.
    """

    name: str
    first: int
    bits: int
    signed: bool = False
    real: bool = False
    factor: float = 1
    unit: str = ""
    low: float = 0
    high: float = 0
    values: Mapping[int, str] = field(default_factory=dict)
    comment: str = ""
    selector: str = ""
    when: tuple[range, ...] = ()


@dataclass(frozen=True, slots=True)
class Message:
    """A message with its sender and receivers; `cycle` in ms, 0: not periodic."""

    name: str
    can_id: int
    octets: int
    sender: str
    signals: Sequence[Signal]
    extended: bool = False
    receivers: Sequence[str] = ()
    cycle: int = 0
    comment: str = ""


class Names:
    """Gives each thing of a space of names a name of its own."""

    def __init__(self) -> None:
        self._given: set[str] = set()

    def add(self, wanted: str) -> str:
        """Return an identifier: `wanted`, changed if it is taken or not valid."""
        name = re.sub(r"\W", "_", wanted, flags=re.ASCII) or "_"
        if name[0].isdigit():
            name = f"_{name}"
        if name in _KEYWORDS or name == NOBODY:
            name += "_"
        unique, number = name, 2
        while unique in self._given:
            unique, number = f"{name}_{number}", number + 1
        self._given.add(unique)
        return unique


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Return the names of at most 32 characters for unique names, as a number at the end."""
    names = list(names)
    given = {name for name in names if len(name) <= MAX_NAME}
    result, number = {}, 0
    for name in names:
        short = name
        while len(short) > MAX_NAME or (short != name and short in given):
            short, number = f"{name[: MAX_NAME - 5]}_{number:04}", number + 1
        given.add(short)
        result[name] = short
    return result


def quoted(text: str) -> str:
    """Return a text as a string of the file, which has neither escapes nor line ends."""
    plain = " ".join(text.split()).replace("\\", "/").replace('"', "'")
    plain = "".join(c if " " <= c <= "~" or c >= "\xa0" else "?" for c in plain)
    return f'"{plain.encode(ENCODING, "replace").decode(ENCODING)}"'


def has_characters(text: str) -> bool:
    """Return whether a DBC file has the characters of a text."""
    return all(c.isspace() or " " <= c <= "~" or "\xa0" <= c <= "\xff" for c in text)


def dbc_text(
    messages: Sequence[Message],
    nodes: Mapping[str, str],
    *,
    comment: str = "",
    bit_rate: int = 0,
) -> str:
    """Return the text of a file; `nodes` are comments by name, `bit_rate` is in bit/s."""
    return "".join(f"{line}\n" for line in _lines(messages, nodes, comment, bit_rate))


def _lines(
    messages: Sequence[Message], nodes: Mapping[str, str], comment: str, bit_rate: int
) -> Iterator[str]:
    node_names = short_names(nodes)
    message_names = short_names(message.name for message in messages)
    yield _HEAD
    yield " ".join(["BU_:", *node_names.values()])
    described = [_Described(message, message_names, node_names) for message in messages]
    for of in described:
        yield ""
        yield from of.frame()
    yield ""
    if comment:
        yield f"CM_ {quoted(comment)};"
    for name, text in nodes.items():
        if text:
            yield f"CM_ BU_ {node_names[name]} {quoted(text)};"
    for of in described:
        yield from of.comments()
    yield _DEFINITIONS.rstrip()
    yield f'BA_ "Baudrate" {bit_rate};'
    for name, short in node_names.items():
        if name != short:
            yield f'BA_ "SystemNodeLongSymbol" BU_ {short} {quoted(name)};'
    for part in ("attributes", "values", "reals", "selections"):
        for of in described:
            yield from getattr(of, part)()


class _Described:
    """The lines about a message."""

    def __init__(
        self,
        message: Message,
        message_names: Mapping[str, str],
        node_names: Mapping[str, str],
    ) -> None:
        self._message = message
        self._name = message_names[message.name]
        self._names = short_names(signal.name for signal in message.signals)
        self._number = message.can_id | (_EXTENDED if message.extended else 0)
        self._sender = node_names.get(message.sender, NOBODY)
        receivers = [node_names[name] for name in message.receivers]
        self._receivers = ",".join(receivers) or NOBODY
        self._selectors = {s.selector for s in message.signals if s.selector}

    def frame(self) -> Iterator[str]:
        message = self._message
        yield f"BO_ {self._number} {self._name}: {message.octets} {self._sender}"
        for signal in message.signals:
            yield self._signal(signal)

    def _signal(self, signal: Signal) -> str:
        place = f"{signal.first}|{signal.bits}@1{'-' if self._signed(signal) else '+'}"
        scale = f"({_number(signal.factor)},0)"
        limits = f"[{_number(signal.low)}|{_number(signal.high)}]"
        selection = f"m{signal.when[0].start}" if signal.selector else ""
        if signal.name in self._selectors:
            selection += "M"
        name = f"{self._names[signal.name]} {selection}".rstrip()
        unit = quoted(signal.unit)
        return f" SG_ {name} : {place} {scale} {limits} {unit} {self._receivers}"

    @staticmethod
    def _signed(signal: Signal) -> bool:
        return signal.signed or signal.real

    def comments(self) -> Iterator[str]:
        if self._message.comment:
            yield f"CM_ BO_ {self._number} {quoted(self._message.comment)};"
        for signal in self._message.signals:
            if signal.comment:
                yield f"CM_ SG_ {self._of(signal)} {quoted(signal.comment)};"

    def attributes(self) -> Iterator[str]:
        message = self._message
        if message.name != self._name:
            long = quoted(message.name)
            yield f'BA_ "SystemMessageLongSymbol" BO_ {self._number} {long};'
        if message.cycle:
            yield f'BA_ "GenMsgCycleTime" BO_ {self._number} {message.cycle};'
        for signal in message.signals:
            if self._names[signal.name] != signal.name:
                long = f"{self._of(signal)} {quoted(signal.name)}"
                yield f'BA_ "SystemSignalLongSymbol" SG_ {long};'

    def values(self) -> Iterator[str]:
        for signal in self._message.signals:
            if signal.values:
                pairs = (f"{v} {quoted(text)}" for v, text in signal.values.items())
                yield f"VAL_ {self._of(signal)} {' '.join(pairs)} ;"

    def reals(self) -> Iterator[str]:
        for signal in self._message.signals:
            if signal.real:
                kind = 2 if signal.bits == 64 else 1
                yield f"SIG_VALTYPE_ {self._of(signal)} : {kind};"

    def selections(self) -> Iterator[str]:
        if not any(
            s.selector and s.name in self._selectors for s in self._message.signals
        ):
            return
        for signal in self._message.signals:
            if signal.selector:
                ranges = ", ".join(f"{r.start}-{r.stop - 1}" for r in signal.when)
                selector = self._names[signal.selector]
                yield f"SG_MUL_VAL_ {self._of(signal)} {selector} {ranges};"

    def _of(self, signal: Signal) -> str:
        return f"{self._number} {self._names[signal.name]}"


def _number(value: float) -> str:
    if isinstance(value, int) or (value.is_integer() and abs(value) < 1e15):
        return str(int(value))
    return repr(value)
