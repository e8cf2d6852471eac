"""The codecs in C and in Python: equal octets, values and errors, for drawn types and values."""

from __future__ import annotations

import gc
import sys
from array import array
from collections.abc import Callable, Iterator
from contextlib import suppress
from decimal import Decimal
from enum import IntEnum
from functools import partial
from pathlib import Path
from random import Random
from typing import Any

import emitted
import pytest
import speed
from random_types import Definitions, Values
from seeds import budget, cases

from rtgen.facts.numeric import FORMS, Numeric
from rtgen.runtime import InPort, OutPort
from rtgen.runtime.cdr import Aggregated, CdrError, Union
from rtgen.runtime.marshalling import compiler, tables
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
)
from rtgen.runtime.marshalling.layouts.formats import CLASSIC, Format
from rtgen.runtime.marshalling.layouts.trees import can_evolve, is_dynamic
from rtgen.runtime.ports.data_ports import DataConnector
from rtgen.runtime.timing.guards import SINGLE_THREAD
from rtgen.runtime.values import AnyValue

sys.path.append(str(Path(__file__).parents[2] / "fuzz"))
sys.path.append(str(Path(__file__).parents[2] / "tools" / "diff"))

from octets import changed
from wire_values import sample
from wire_versions import Drawing

FORMATS = (CLASSIC, Format(1), Format(2))
CHANGES = 6
VALUES = 2


@pytest.fixture(autouse=True)
def in_c(monkeypatch: pytest.MonkeyPatch) -> None:
    """Types have codecs in C if `tables` covers them."""
    module = speed.module()
    tables.prepare(module)
    monkeypatch.setattr(tables, "speed", lambda: module)


class Both:
    """The functions of a kind for a type, in C and in Python."""

    def __init__(self, kind: str, descriptor: Any, format_: Format) -> None:
        self.in_python = compiler.compiled_in_python(kind, descriptor, format_)
        self.in_c = tables.codec(kind, descriptor, format_, lambda: _leave)
        self._may_leave = is_dynamic(descriptor) or (
            format_.version > 0 and can_evolve(descriptor)
        )

    def taken(self, *arguments: Any) -> str:
        """Return the outcome of both, which C does not leave to Python."""
        wanted = _outcome(self.in_python, *arguments)
        try:
            outcome = _outcome(self.in_c, *arguments)
        except _LeftError:
            raise AssertionError(f"{arguments} are left to Python: {wanted}") from None
        assert outcome == wanted
        return outcome

    def given(self, *arguments: Any, is_rare: bool = False) -> str:
        """Return the outcome of arguments that C may leave to Python.

        These are errors, octets of other versions of a type or of rare types in an `any`, and
        values in a rare form.
        """
        wanted = _outcome(self.in_python, *arguments)
        try:
            outcome = _outcome(self.in_c, *arguments)
        except _LeftError:
            assert (
                is_rare or self._may_leave or wanted.startswith("CdrError")
            ), arguments
        else:
            assert outcome == wanted
        return wanted


class _LeftError(BaseException):
    """Raised where a codec calls the function in Python."""


def _leave(*_: Any, **__: Any) -> Any:
    raise _LeftError


def _outcome(function: Callable[..., Any], *arguments: Any) -> str:
    try:
        return repr(function(*arguments))
    except CdrError as error:
        return f"CdrError at {error.path}: {error.message}"


class Checked:
    """The codecs of a type in a format."""

    def __init__(self, class_: Any, format_: Format) -> None:
        descriptor = class_._descriptor_
        self._class = class_
        self._encode = Both("to_cdr", descriptor, format_)
        self._decode = Both("from_cdr", descriptor, format_)
        self._is_aggregated = issubclass(class_, Aggregated)
        self._copies = self._is_aggregated and not is_dynamic(descriptor)
        if self._is_aggregated:
            self._copy = Both("_snapshot_", descriptor, CLASSIC)
        self._is_struct = issubclass(class_, Aggregated) and not issubclass(
            class_, Union
        )
        if self._is_struct:
            self._prefix = Both("from_prefix", descriptor, format_)
        self._has_payload = format_.version > 0 and self._is_aggregated
        if self._has_payload:
            self._payload = Both("to_payload", descriptor, format_)

    @classmethod
    def covered(cls, class_: Any, format_: Format) -> Checked | None:
        """Return the codecs of a type; None if they are in Python alone."""
        descriptor = class_._descriptor_
        if tables.codec("to_cdr", descriptor, format_, lambda: _leave) is None:
            return None
        return cls(class_, format_)

    def value(self, value: Any, draw: Random) -> None:
        """Compare a value, its octets, and changes of both."""
        for little in (True, False):
            if self._encode.given(value, little).startswith("CdrError"):
                continue  # a member is None, and classic CDR has no optional ones
            self._encode.taken(value, little)
            octets = self._encode.in_python(value, little)
            source = draw.choice((bytes, bytearray, memoryview))(octets)
            self._decode.taken(self._class, source, little)
            assert (
                self._encode.in_c(
                    self._decode.in_c(self._class, octets, little), little
                )
                == octets
            )
            if self._has_payload:
                self._payload.taken(value, little)
            for _ in range(CHANGES):
                self.octets(changed(draw, octets, little), little)
            for end in draw.choices(range(len(octets) + 1), k=4):
                self.octets(octets[:end], little)
        if self._copies:
            self._copy.taken(value)

    def octets(self, octets: bytes, little: bool) -> None:
        """Compare what octets are decoded to."""
        outcome = self._decode.given(self._class, octets, little)
        if self._is_struct:
            self._prefix.given(self._class, octets, little)
        if not outcome.startswith("CdrError"):
            self._encode.given(
                self._decode.in_python(self._class, octets, little), little
            )

    def damaged(self, value: Any, draw: Random) -> None:
        """Compare a value of which a part is of another kind."""
        damaged = _damaged(value, draw)
        self._encode.given(damaged, draw.random() < 0.5, is_rare=True)
        if self._copies and isinstance(damaged, self._class):
            with suppress(AttributeError, TypeError, ValueError):  # which Python raises
                self._copy.given(damaged, is_rare=True)


_ODD = (None, "x", b"x", -1, 1 << 40, 1 << 64, 1.5, 1e300, [], [None], (1, 2), {}, True)
_ODD += (
    "\0",
    "a\ud800",
    "\u6f22",
    "\U0001f600",
    [1],
    array("d", [1.0]),
    bytearray(b"ab"),
)
_ODD += (range(3), Decimal(1), IntEnum("Odd", "A").A)


def _damaged(value: Any, draw: Random) -> Any:
    """Return the value with another part in place of one, anywhere inside it."""
    if isinstance(value, Aggregated) and draw.random() < 0.9:
        name = draw.choice(value.__struct_fields__ or ("",))
        made = value._snapshot_()
        if name:
            setattr(made, name, _damaged(getattr(value, name), draw))
        return made
    if isinstance(value, list) and value and draw.random() < 0.7:
        place = draw.randrange(len(value))
        return [*value[:place], _damaged(value[place], draw), *value[place + 1 :]]
    return draw.choice(_ODD)


def _drawn(number: int, folder: Path) -> Iterator[tuple[Any, Any, Random]]:
    """Yield classes and values: types with headers by an odd number, those of CORBA by an even.

    Numbers have each form in turn.
    """
    draw = Random(number)
    numeric = FORMS[number // 2 % len(FORMS)]
    if number % 2:
        text = Drawing(draw).definitions().text()
        package = emitted.emit_text(folder, text, numeric)
        for class_ in emitted.classes(package):
            if issubclass(class_, Aggregated):
                for _ in range(VALUES):
                    yield class_, sample(class_._descriptor_, draw), draw
        return
    text = Definitions(draw, f"Drawn{number}").text(20)
    package = emitted.emit_text(folder, text, numeric)
    classes = [c for c in emitted.classes(package) if hasattr(c, "to_cdr")]
    covered = [c._descriptor_ for c in classes if Checked.covered(c, CLASSIC)]
    anys = [d for d in covered if not isinstance(d, ExceptionDescriptor)] + _IN_ANY
    for class_ in classes:
        for _ in range(VALUES):
            values = Values(draw, anys, state=False)
            yield class_, values.value(class_._descriptor_), draw


_IN_ANY: list[Descriptor] = [
    *map(PrimitiveDescriptor, ("null", "long", "double", "char", "any")),
    *(StringDescriptor(), StringDescriptor(True, 5), FixedDescriptor(5, 2)),
    SequenceDescriptor(PrimitiveDescriptor("octet")),
    SequenceDescriptor(StringDescriptor(), 3),
    ArrayDescriptor(PrimitiveDescriptor("short"), (2, 3)),
]


@pytest.mark.nightly
def test_drawn_types(tmp_path: Path) -> None:
    covered = 0
    for number in cases(20, always=6):
        folder = tmp_path / str(number)
        folder.mkdir()
        for class_, value, draw in _drawn(number, folder):
            for format_ in FORMATS:
                checked = Checked.covered(class_, format_)
                if checked is not None and hasattr(
                    class_, f"to_xcdr{format_.version or 2}"
                ):
                    covered += 1
                    checked.value(value, draw)
                    checked.damaged(value, draw)
    assert covered


def _parts(value: Any) -> Iterator[Any]:
    """Yield a value and all of its parts that can change."""
    yield value
    if isinstance(value, Aggregated):
        inner = [getattr(value, name) for name in value.__struct_fields__]
    elif isinstance(value, dict):
        inner = [*value.values()]
    else:
        inner = value if isinstance(value, list) else []
    for each in inner:
        if isinstance(each, Aggregated | list | dict | array):
            yield from _parts(each)


def test_samples_that_a_reader_holds_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ports make new samples of old ones, but not of a part that somebody refers to."""
    speed.choose_for_ports(monkeypatch, speed.module())
    again = 0
    for number in cases(20, always=4):
        folder = tmp_path / str(number)
        folder.mkdir()
        values: dict[type[Any], list[Any]] = {}
        draw = Random(number)
        for class_, value, _ in _drawn(number, folder):
            if issubclass(class_, Aggregated) and not is_dynamic(class_._descriptor_):
                values.setdefault(class_, []).append(value)
        for class_, samples in values.items():
            out, port = OutPort("out", class_), InPort("in", class_)
            DataConnector("c", out, port, {}, lambda: SINGLE_THREAD).attach()
            held: list[tuple[Any, str]] = []
            seen: set[int] = set()
            for _ in range(12):
                sample_ = draw.choice(samples)
                out.write(sample_)
                got = port.read()
                assert got is not sample_
                assert repr(got) == repr(sample_)
                again += id(got) in seen
                seen.add(id(got))
                if draw.random() < 0.5:
                    part = draw.choice([*_parts(got)])
                    held.append((part, repr(part)))
                del got
            assert [repr(part) for part, _ in held] == [text for _, text in held]
    assert again


def test_characters_at_each_place_of_a_wide_string(tmp_path: Path) -> None:
    """NUL and lone surrogates have no octets; their neighbours do, however units are read."""
    line = emitted.emit_text(tmp_path, "struct Line { wstring text; };")._idl.case.Line
    encode = Both("to_cdr", line._descriptor_, CLASSIC)
    decode = Both("from_cdr", line._descriptor_, CLASSIC)
    for each in "\x00\x01\x80\xff\u0100\u8000\ud7ff\ud800\udfff\ue000\uffff\U00010000":
        has_octets = each != "\x00" and not 0xD800 <= ord(each) < 0xE000
        for length in (*range(1, 10), 17):
            for place in range(length):
                for other in "a\u6f22":
                    row = [other] * length
                    row[place] = each
                    value = line("".join(row))
                    if has_octets:
                        encode.taken(value)
                        assert decode.taken(line, value.to_cdr()) == repr(value)
                    else:
                        assert encode.given(value).startswith("CdrError at Line.text")


def test_discriminators_that_no_label_has(tmp_path: Path) -> None:
    """Samples are copied as they are, whatever the discriminator; encoding says what is wrong."""
    text = """
    union Chosen switch (short) { case 1: string text; };
    union Marked switch (char) { case 'a': sequence<long> row; };
    struct Held { Chosen first; Marked second; };
    """
    case = emitted.emit_text(tmp_path, text)._idl.case
    copy = Both("_snapshot_", case.Held._descriptor_, CLASSIC)
    encode = Both("to_cdr", case.Held._descriptor_, CLASSIC)
    for odd in (None, "", "ab", 0, -1 << 63, 1 << 63, 1 << 64, -1 << 64, 1.5, b"a"):
        for value in (
            case.Held(case.Chosen(odd, None), case.Marked("a", [1])),
            case.Held(case.Chosen(1, "a"), case.Marked(odd, None)),
        ):
            assert copy.taken(value) == repr(value)
            encode.given(value, is_rare=True)


@pytest.mark.parametrize("numeric", FORMS)
def test_numbers_of_each_length_and_form(tmp_path: Path, numeric: Numeric) -> None:
    """What is decoded is of the same class, empty or not."""
    text = """
    struct Held {
        sequence<double> one; sequence<sequence<short> > many; sequence<octet> octets;
        sequence<unsigned long, 80> pair[2]; map<string, sequence<float> > named;
    };
    """
    held = emitted.emit_text(tmp_path, text, numeric)._idl.case.Held
    for format_ in (Format(1), Format(2)):
        decode = Both("from_cdr", held._descriptor_, format_)
        encode = Both("to_cdr", held._descriptor_, format_)
        for count in (0, 1, 2, 63, 64, 65, 80):
            row, octets = [*range(count)], bytes(count)
            value = held(row, [row, row], octets, [row, row], {"a": row})
            for little in (True, False):
                encoded = encode.in_c(value, little)
                assert encoded == encode.in_python(value, little)
                decode.taken(held, encoded, little)
                classes = [
                    {
                        name: type(getattr(decoded, name))
                        for name in held.__struct_fields__
                    }
                    for decoded in (
                        decode.in_python(held, encoded, little),
                        decode.in_c(held, encoded, little),
                    )
                ]
                assert classes[0] == classes[1]


IDL = """
module Kept {
    enum Hue { RED, GREEN };
    bitmask Bits { @position(0) LOW, @position(3) HIGH };
    union Choice switch (Hue) { case RED: string text; default: sequence<double> row; };
    struct Part { string name; wstring wide; Hue shade; Bits flags; long double quad; };
    @mutable struct Loose { @optional string note; map<string, Part> named; };
    struct All {
        Part first; sequence<Part> many; Choice one; sequence<octet> raw; double grid[2][3];
        @optional Loose rest; sequence<long> numbers; short level;
    };
    struct Point { double x; };
    struct Held { any content; sequence<string> texts; };
};
"""


@pytest.mark.nightly
def test_nothing_is_kept_of_many_values(tmp_path: Path) -> None:
    """References that were not given back would be allocated blocks, failures included."""
    kept = emitted.emit_text(tmp_path, IDL)._idl.case
    part = kept.Part("a name", "\u6f22", kept.Hue.GREEN, kept.Bits.HIGH, 0.5)
    loose = kept.Loose("a note", {"one": part, "two": part})
    row = kept.Choice(kept.Hue.GREEN, [0.25 * n for n in range(9)])
    whole = kept.All(
        part, [part] * 3, row, b"abc", [[0.5] * 3] * 2, loose, [*range(500, 599)]
    )
    held = kept.Held(
        AnyValue(kept.Point._descriptor_, kept.Point(1.5)), ["a text", "b text"]
    )
    functions = []
    for value, format_ in ((whole, Format(1)), (whole, Format(2)), (held, CLASSIC)):
        descriptor = type(value)._descriptor_
        kinds = ("to_cdr", "from_cdr", "_snapshot_")
        encode, decode, copy = (
            tables.codec(kind, descriptor, format_, lambda: lambda *_: None)
            for kind in kinds
        )
        octets = encode(value)
        broken = [octets[:end] for end in range(0, len(octets), 7)]
        functions.append(
            partial(_exercise, encode, decode, copy, value, octets, broken)
        )

    def blocks(times: int) -> int:
        for _ in range(times):
            for function in functions:
                function()
        gc.collect()
        return sys.getallocatedblocks()

    blocks(20)
    first = blocks(20)
    assert blocks(budget(500)) < first + 200


def _exercise(
    encode: Any, decode: Any, copy: Any, value: Any, octets: bytes, broken: list[bytes]
) -> None:
    type_ = type(value)
    assert decode(type_, encode(value)) == value
    assert decode(type_, encode(value, False), False) == value
    assert copy is None or copy(value) == value
    for cut in broken:
        assert decode(type_, cut) is None
    name = value.__struct_fields__[-1]
    right = getattr(value, name)
    setattr(value, name, object())
    assert encode(value) is None
    assert copy is None or name == "level" or copy(value) is None
    setattr(value, name, right)
