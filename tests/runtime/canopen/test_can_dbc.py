"""DBC files of buses: readers decode frames to the names and values of `rtgen can monitor`."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from random import Random
from typing import TypeAlias

import can
import canmatrix
import canmatrix.formats
import cantools
import pytest
import seeds
from cantools.database.can import Database, Message
from eds_files import Thing, eds, entry
from patience import PATIENCE
from random_buses import RandomBus

from rtgen.cli import run
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends import bus as front_end
from rtgen.facts.canopen import (
    DAY,
    EPOCH,
    KIND_BITS,
    KINDS,
    MILLISECOND,
    NUMBER_KINDS,
    DataType,
)
from rtgen.runtime.canopen.values import from_bits
from rtgen.runtime.canopen.wire.frames import Frame
from rtgen.tools.can.dbc.database import Names, quoted, short_names
from rtgen.tools.can.dbc.messages import bus_dbc
from rtgen.tools.can.decoding.decoder import Decoder
from rtgen.tools.can.decoding.node_index import NodeIndex, bus_index
from rtgen.tools.can.decoding.object_values import Field
from rtgen.tools.can.decoding.pdo_fields import Route, routes

SPECS = Path(__file__).parents[3] / "specs" / "canopen"
MOST_BUSES = 50
Reader: TypeAlias = Callable[[Frame], Mapping[str, float]]
"""Decodes a frame to its values as on the bus."""


@dataclass
class Written:
    """A bus with its DBC file, as two readers read it."""

    index: NodeIndex
    content: bytes
    left_out: list[str]

    @cached_property
    def cantools(self) -> Database:
        database = cantools.database.load_string(self.content.decode("cp1252"), "dbc")
        assert isinstance(database, Database)
        return database

    @cached_property
    def canmatrix(self) -> canmatrix.CanMatrix:
        matrix = canmatrix.formats.loads_flat(
            self.content, "dbc", dbcImportEncoding="cp1252"
        )
        assert isinstance(matrix, canmatrix.CanMatrix)
        return matrix

    def raw(self, frame: Frame) -> dict[str, float]:
        """Decode a frame with both readers, and return its values as on the bus."""
        message = self.message(frame)
        values = message.decode(frame.data, decode_choices=False, scaling=False)
        physical = message.decode(frame.data, decode_choices=False)
        identifier = canmatrix.ArbitrationId(frame.can_id, frame.extended)
        matrix_frame = self.canmatrix.frame_by_id(identifier)
        assert matrix_frame is not None
        assert matrix_frame.name == message.name
        others = matrix_frame.decode(bytearray(frame.data))
        assert isinstance(values, dict)
        assert isinstance(physical, dict)
        assert set(others) == set(values)
        for name, value in values.items():
            assert isinstance(value, (int, float))
            assert same(float(others[name].raw_value), value)
            assert same(float(others[name].phys_value), physical[name])
        return values

    def message(self, frame: Frame) -> Message:
        messages = {
            (m.frame_id, m.is_extended_frame): m for m in self.cantools.messages
        }
        return messages[frame.can_id, frame.extended]


def same(one: object, other: object) -> bool:
    """Return whether two values are equal, but for the last digits of a product."""
    assert isinstance(one, (int, float))
    assert isinstance(other, (int, float))
    if isinstance(one, float) or isinstance(other, float):
        if math.isnan(one):
            return math.isnan(other)
        return math.isclose(one, other, rel_tol=1e-14)
    return one == other


def written(file: Path) -> Written | None:
    """Return the DBC of a bus file; None if the file has errors."""
    read = front_end.load(file, root=file.parent)
    if read.bus is None or has_errors(read.diagnostics):
        return None
    index = bus_index(read.bus)
    content, left_out = bus_dbc(read.bus, index)
    assert bus_dbc(read.bus, index)[0] == content
    return Written(index, content, [d.message for d in left_out])


def described(file: Path) -> Written:
    result = written(file)
    assert result is not None
    return result


ONE_NODE = """[bus]
bit_rate = 500
[device.d]
eds = "d.eds"
[node.n]
device = "d"
id = 5
"""
UNITS = ("", "rad", "°C", "µm", "m/s²")
TYPES = (1, 2, 3, 4, 5, 6, 7, 8, 9, 0xA, 0xB, 0xC, 0xD, *range(0x10, 0x17))
TYPES += (*range(0x18, 0x1C), 0xA0)
KIND_OF = {code: KINDS[DataType(code)] for code in TYPES}
FIXED = {code: KIND_BITS[kind] for code, kind in KIND_OF.items() if kind in KIND_BITS}
NUMBERS = [code for code, kind in KIND_OF.items() if kind in NUMBER_KINDS]


def drawn_bus(chance: Random, folder: Path) -> Path:
    """Write a bus of nodes whose PDOs map objects of all types, with factors and units."""
    lines = ["[bus]", "bit_rate = 500", f"sync = {chance.choice((0.01, 0.02))}"]
    nodes = [f"n{number}" for number in range(chance.randrange(1, 4))]
    for number, node in enumerate(nodes):
        things = [Thing(f"Value {place}", chance.choice(TYPES)) for place in range(20)]
        things = [replace(thing, default="") for thing in things]
        pdos: dict[int, list[int]] = {}
        for pdo in range(1, 5):
            pdos[pdo], left = [], 64
            for place in chance.sample(range(20), chance.randrange(1, 8)):
                bits = FIXED.get(things[place].type, 8 * chance.randrange(1, 5))
                if bits <= left:
                    pdos[pdo].append(entry(0x2000 + place, bits))
                    left -= bits
        sent, taken = {n: pdos[n] for n in (1, 2)}, {n: pdos[n] for n in (3, 4)}
        (folder / f"{node}.eds").write_text(eds(things, sent, taken), encoding="utf-8")
        lines += [f"[device.d{number}]", f'eds = "{node}.eds"']
        numeric = [place for place, thing in enumerate(things) if thing.type in NUMBERS]
        for table in ("factors", "units"):
            lines.append(f"[device.d{number}.{table}]")
            for place in chance.sample(numeric, min(4, len(numeric))):
                factor = chance.choice((0.1, 1e-3, 2.2439947525641379e-4, -0.5, 3.0))
                value = (
                    factor if table == "factors" else f'"{chance.choice(UNITS[1:])}"'
                )
                lines.append(f'"{0x2000 + place:04X}" = {value}')
        lines += [f"[node.{node}]", f'device = "d{number}"', f"id = {number * 7 + 3}"]
    file = folder / "bus.toml"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def expected(field: Field, bits: int, raw: dict[str, float]) -> Iterator[bool]:
    """Yield whether the values of a reader are that of a field of the monitor."""
    kind, value, name = field.thing.kind, field.value, field.name
    if kind.startswith("time_") and bits >= KIND_BITS[kind] and isinstance(value, int):
        milliseconds = int(raw[f"{name}_days"]) * DAY + int(raw[f"{name}_ms"])
        start = EPOCH if kind == "time_of_day" else 0
        yield (start + milliseconds) * MILLISECOND == value
        return
    found = raw[name]
    if isinstance(value, str):
        yield from_bits(kind, int(found) & (1 << bits) - 1, bits) == value
        return
    if isinstance(value, bytes):
        whole = int(found) & (1 << bits) - 1
        yield whole == int.from_bytes(value, "little")
    elif kind == "bool":
        yield (found != 0) is bool(value)
    else:
        yield same(float(found) if kind in ("r32", "r64") else found, value)


def compared(
    of: Written, chance: Random, count: int, further: Reader | None = None
) -> int:
    """Compare random frames of the PDOs of a bus; return how many there were.

    `further` is a reader beside the two.
    """
    pdos: dict[tuple[int, bool], Route] = {}
    for node in of.index.nodes.values():
        for key, route in routes(node, node.parameters):
            if key not in pdos or route.pdo.startswith("t"):
                pdos[key] = route
    decoder = Decoder(of.index)
    frames = 0
    for (can_id, extended), route in sorted(pdos.items(), key=lambda pair: pair[0]):
        if route.multiplexed:
            continue
        names = [mapped.thing.name for mapped in route.mapped]
        if len(set(names)) < len(names):
            continue
        for _ in range(count):
            frame = Frame(can_id, chance.randbytes(route.octets), extended=extended)
            decoded = decoder.decode(frame)
            assert of.message(frame).name == f"{decoded.name}_{decoded.kind}"
            raw = of.raw(frame)
            if further is not None:
                others = further(frame)
                assert set(others) == set(raw)
                assert all(same(others[name], raw[name]) for name in raw), frame
            for mapped, field in zip(route.mapped, decoded.fields, strict=True):
                assert all(expected(field, mapped.bits, raw)), (field, raw)
                assert_physical(of, frame, field)
            frames += 1
    return frames


@contextmanager
def hilspy_reader(content: bytes, folder: Path) -> Iterator[Reader]:
    """Yield the reader of hilspy, whose code is of Rust: frames go over a bus in this process."""
    import hilspy

    file = folder / "bus.dbc"
    file.write_bytes(content)
    bus = f"mem://{folder.name}"
    with (
        hilspy.open(bus, f"dbc:{file}", scaling=False, decode_choices=False) as reader,
        hilspy.open(bus) as sender,
    ):

        def read(frame: Frame) -> dict[str, float]:
            sent = {"id": frame.can_id, "extended": frame.extended}
            sender.send(hilspy.Message(data=frame.data, **sent))
            message = reader.recv(PATIENCE)
            assert message is not None
            values: dict[str, float] = message.fields
            return values

        yield read


def assert_physical(of: Written, frame: Frame, field: Field) -> None:
    """Unit and physical value are those that the monitor shows."""
    signals = {signal.name: signal for signal in of.message(frame).signals}
    signal = signals.get(field.name)
    if signal is None:
        return
    assert (signal.unit or "") == field.thing.unit
    if field.thing.factor is not None and isinstance(field.value, (int, float)):
        values = of.message(frame).decode(frame.data, decode_choices=False)
        assert isinstance(values, dict)
        assert same(float(values[field.name]), float(field.physical))


@pytest.mark.sampled(0)
@pytest.mark.parametrize("number", seeds.cases(20))
def test_pdos_of_drawn_buses(number: int, tmp_path: Path) -> None:
    chance = Random(number)
    of = described(drawn_bus(chance, tmp_path))
    assert compared(of, chance, 40)
    assert not of.left_out


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.slow
def test_three_readers_agree_on_ten_thousand_frames(tmp_path: Path) -> None:
    frames = 0
    for number in range(MOST_BUSES):
        folder = tmp_path / f"bus{number}"
        folder.mkdir()
        chance = Random(seeds.seed() + number)
        of = described(drawn_bus(chance, folder))
        with hilspy_reader(of.content, folder) as further:
            frames += compared(of, chance, 100, further)
        if frames >= 10_000:
            break
    assert frames >= 10_000


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.slow
@pytest.mark.parametrize("recorder", [".log", ".asc", ".blf", ".trc"])
def test_the_tools_of_others_show_what_replay_shows(
    recorder: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A logger of python-can records, `cantools decode` reads the frames with the DBC file."""
    bus = SPECS / "rh3_beego.toml"
    chance = Random(seeds.seed())
    identifiers = {0x181: 3, 0x182: 3, 0x201: 3, 0x281: 8, 0x282: 8, 0x701: 1}
    recording = tmp_path / f"run{recorder}"
    lines = []
    with can.Logger(recording) as logger:
        for number in range(60):
            identifier, octets = chance.choice(sorted(identifiers.items()))
            data = b"\5" if octets == 1 else chance.randbytes(octets)
            of_frame = {"arbitration_id": identifier, "is_extended_id": False}
            logger(can.Message(timestamp=number / 100, data=data, **of_frame))
            lines.append(f"({number / 100:f}) can0 {identifier:03X}#{data.hex()}\n")
    assert run(["convert", str(bus), "--to", "dbc", "-o", str(tmp_path)]) == 0
    command = [sys.executable, "-m", "cantools", "decode", "--single-line"]
    shown = subprocess.run(
        [*command, str(tmp_path / "rh3_beego.dbc")],
        input="".join(lines),
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    capfd.readouterr()
    assert (
        run(["can", "replay", str(recording), *f"--decode --json --bus {bus}".split()])
        == 0
    )
    rows = [json.loads(each) for each in capfd.readouterr().out.splitlines()]
    for line, row in zip(shown.splitlines(), rows, strict=True):
        match = re.fullmatch(r".* :: (\w+)\((.*)\)", line)
        assert match is not None
        name, fields = match.groups()
        assert name == f"{row['name']}_{row['kind']}"
        signals = dict(re.findall(r"(\w+): (.*?)(?=, \w+: |$)", fields))
        if row["kind"] == "heartbeat":
            assert signals["state"] == row["text"]
        for each in row.get("values", ()):
            text = signals[each["name"]]
            if text == each.get("words"):
                continue
            value, _, unit = text.partition(" ")
            assert unit == each.get("unit", "")
            assert same(float(value), float(each["value"]))


@pytest.mark.sampled(0)
@pytest.mark.parametrize("number", seeds.cases(20))
def test_drawn_communication_parameters(number: int, tmp_path: Path) -> None:
    """Identifiers, mappings and lengths are those in force after the configuration."""
    of = written(RandomBus(number, tmp_path).file)
    if of is not None:
        compared(of, Random(number), 10)
        assert len(
            {(m.frame_id, m.is_extended_frame) for m in of.cantools.messages}
        ) == (len(of.cantools.messages))


@pytest.fixture(scope="module", params=["pdo_linking", "rh3_beego"])
def known(request: pytest.FixtureRequest) -> Written:
    return described(SPECS / f"{request.param}.toml")


@pytest.mark.sampled(1)
def test_pdos_of_example_buses(known: Written) -> None:
    assert compared(known, Random(1), 5)


@pytest.mark.sampled(1)
def test_sdo_messages_of_every_object(known: Written) -> None:
    """An expedited message has name, verb and value; an abort has its text."""
    node = next(iter(known.index.nodes.values()))
    chance, decoder = Random(2), Decoder(known.index)
    for thing in chance.sample(sorted(node.objects.values(), key=str), 25):
        bits = KIND_BITS.get(thing.kind, 32)
        octets = min((bits + 7) // 8, 4)
        size = (4 - octets) << 2 | 3
        index, subindex = thing.number
        head = index.to_bytes(2, "little") + bytes((subindex,))
        data = chance.randbytes(octets) if thing.kind != "bool" else b"\1"
        for can_id, command in ((0x600, 0x20), (0x580, 0x40)):
            whole = bytes((command | size,)) + head + data.ljust(4, b"\0")
            frame = Frame(can_id + node.id, whole)
            shown, raw = decoder.decode(frame), known.raw(frame)
            values = known.message(frame).decode(frame.data)
            assert isinstance(values, dict)
            verb, target = str(values["command"]), str(values["object"])
            assert shown.text.startswith(f"{verb} {target} =")
            name = list(values)[-1]
            assert name in (thing.name, f"{thing.name}_2")
            renamed = {thing.name: raw[name]}
            if bits <= 32:
                assert all(expected(shown.fields[0], 8 * octets, renamed))
    frame = Frame(0x580 + node.id, bytes.fromhex("8000100000000206"))
    values = known.message(frame).decode(frame.data)
    assert isinstance(values, dict)
    assert str(values["abort_code"]) in decoder.decode(frame).text


@pytest.mark.sampled(1)
def test_every_sdo_command_is_decoded(known: Written) -> None:
    node = next(iter(known.index.nodes.values()))
    for can_id in (0x600, 0x580):
        for command in range(256):
            frame = Frame(can_id + node.id, bytes((command, 0, 0x10, 0, 1, 2, 3, 4)))
            assert known.raw(frame)["command"] == command


@pytest.mark.sampled(1)
def test_services_have_the_words_of_the_monitor(known: Written) -> None:
    decoder = Decoder(known.index)
    node = next(iter(known.index.nodes.values()))
    for state in (0, 4, 5, 0x7F):
        frame = Frame(0x700 + node.id, bytes((state,)))
        values = known.message(frame).decode(frame.data)
        assert isinstance(values, dict)
        assert known.message(frame).name == f"{node.name}_heartbeat"
        assert decoder.decode(frame).text == str(values["state"])
    for command in (1, 2, 0x80, 0x81, 0x82):
        for target in (0, node.id):
            frame = Frame(0, bytes((command, target)))
            values = known.message(frame).decode(frame.data)
            assert isinstance(values, dict)
            shown = decoder.decode(frame)
            assert (shown.text, shown.name) == (
                str(values["command"]),
                str(values["node"]),
            )
    for code in (0, 0x8130, 0x8250, 0x3100, 0x2300):
        frame = Frame(0x80 + node.id, code.to_bytes(2, "little") + b"\x11\1\2\3\4\5")
        values = known.message(frame).decode(frame.data)
        assert isinstance(values, dict)
        bits = [name for name, value in values.items() if value == 1]
        text = f"{code:04X}h {values['code']} ({', '.join(bits)}) 01 02 03 04 05"
        assert decoder.decode(frame).text == text
        assert known.raw(frame)["additional"] == 0x0504030201


@pytest.mark.sampled(0)
def test_statusword_has_the_words_of_the_monitor() -> None:
    of = described(SPECS / "rh3_beego.toml")
    decoder = Decoder(of.index)
    for word in (0x0250, 0x0231, 0x0233, 0x0237, 0x1637, 0x0218, 0x02B7):
        frame = Frame(0x181, word.to_bytes(2, "little") + bytes(6))
        octets = of.message(frame).length
        frame = Frame(0x181, frame.data[:octets])
        values = of.message(frame).decode(frame.data)
        assert isinstance(values, dict)
        assert (
            f"Statusword={word} ({values['Statusword']})" in decoder.decode(frame).text
        )


@pytest.mark.sampled(0)
def test_nodes_senders_receivers_and_periods() -> None:
    of = described(SPECS / "rh3_beego.toml")
    assert {node.name for node in of.cantools.nodes} == {"left", "right", "manager"}
    sync = of.cantools.get_message_by_name("sync")
    assert (sync.cycle_time, sync.senders, sync.length) == (10, ["manager"], 0)
    assert of.cantools.get_message_by_name("manager_heartbeat").cycle_time == 100
    linked = described(SPECS / "pdo_linking.toml")
    angle = linked.cantools.get_message_by_name("palette_tpdo4")
    assert angle.senders == ["palette"]
    assert angle.receivers == {"motor", "manager"}
    assert "motor.rpdo2" in str(angle.comment)
    assert angle.cycle_time is None
    found = linked.canmatrix.frame_by_name("palette_tpdo4")
    assert found is not None
    assert found.transmitters == ["palette"]


def own_bus(folder: Path, text: str, *things: Thing, bits: int = 0) -> Written:
    """Return the DBC of a node `n` with node-id 5, whose TPDO 1 maps `things`."""
    entries = [
        entry(0x2000 + place, bits or FIXED[thing.type])
        for place, thing in enumerate(things)
    ]
    (folder / "d.eds").write_text(eds(things, {1: entries}), encoding="utf-8")
    bus = f'[bus]\nbit_rate = 500\n[device.d]\neds = "d.eds"\n{text}'
    bus += '[node.n]\ndevice = "d"\nid = 5\n'
    (folder / "bus.toml").write_text(bus, encoding="utf-8")
    return described(folder / "bus.toml")


def test_long_names_are_kept(tmp_path: Path) -> None:
    things = [Thing(f"Temperature of the gear box of axis {n}", 5) for n in range(3)]
    of = own_bus(tmp_path, "", *things)
    names = [f"Temperature_of_the_gear_box_of_axis_{n}" for n in range(3)]
    message = of.cantools.get_message_by_name("n_tpdo1")
    assert [signal.name for signal in message.signals] == names
    short = re.findall(r"^ SG_ (\w+)", of.content.decode("latin-1"), re.MULTILINE)
    assert max(map(len, short)) == 32
    of.raw(Frame(0x185, b"\1\2\3"))


def test_unit_without_characters_is_reported(tmp_path: Path) -> None:
    of = own_bus(tmp_path, '[device.d.units]\n"2000" = "kΩ"\n', Thing("R", 6))
    assert of.left_out == ["n.tpdo1: 2000:0 R: a DBC has no characters for the unit kΩ"]
    assert of.cantools.get_message_by_name("n_tpdo1").signals[0].unit == "k?"


def test_object_that_is_mapped_twice(tmp_path: Path) -> None:
    (tmp_path / "d.eds").write_text(
        eds([Thing("Speed", 6)], {1: [entry(0x2000, 16)] * 2}), encoding="utf-8"
    )
    (tmp_path / "bus.toml").write_text(ONE_NODE, encoding="utf-8")
    of = described(tmp_path / "bus.toml")
    assert of.raw(Frame(0x185, b"\1\0\2\0")) == {"Speed": 1, "Speed_2": 2}


def test_names_that_a_file_cannot_have() -> None:
    names = Names()
    given = [
        names.add(text) for text in ("SG_", "a b", "a_b", "1st", "Vector__XXX", "é")
    ]
    assert given == ["SG__", "a_b", "a_b_2", "_1st", "Vector__XXX_", "_"]
    long = "x" * 40
    assert short_names([long, f"{'x' * 27}_0000"]) == {
        long: f"{'x' * 27}_0001",
        f"{'x' * 27}_0000": f"{'x' * 27}_0000",
    }
    assert quoted('a "b"\n\\c €') == "\"a 'b' /c ?\""


def test_multiplexed_pdo(tmp_path: Path) -> None:
    """Address, then the object by its number, as the monitor shows it."""
    text = eds([Thing("Speed", 3), Thing("Set point", 8)], {1: []})
    section = (
        "[1A00sub0]\nParameterName=Number of entries\nObjectType=7\nDataType=0x0005"
    )
    section += "\nAccessType=rw\nDefaultValue="
    assert f"{section}0" in text
    text = text.replace(f"{section}0", f"{section}254")
    (tmp_path / "d.eds").write_text(text, encoding="utf-8")
    (tmp_path / "bus.toml").write_text(ONE_NODE, encoding="utf-8")
    of = described(tmp_path / "bus.toml")
    frame = Frame(0x185, bytes.fromhex("8500200000feff00"))
    assert of.raw(frame)["Speed"] == -512
    values = of.message(frame).decode(frame.data)
    assert isinstance(values, dict)
    assert str(values["object"]) == "2000:0 Speed"
    frame = Frame(0x185, bytes.fromhex("850120000000803f"))
    assert of.raw(frame) == {"address": 0x85, "object": 0x2001, "Set_point": 1.0}
