"""Bus files: nodes with their values, links, messages, and the schema."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends.bus import load
from rtgen.compiler.frontends.bus.schema import SCHEMA
from rtgen.compiler.layouts.can_messages import Writing, messages
from rtgen.compiler.layouts.can_timing import load as bus_load
from rtgen.compiler.layouts.can_timing import response_times
from rtgen.compiler.model.can_bus import Bus, PdoLink
from rtgen.compiler.model.canopen import Pdo

ROOT = Path(__file__).parents[3]
BASE = ROOT / "tests/golden/eds_errors/base.eds"
BUSES = sorted((ROOT / "specs/canopen").glob("*.toml"))


def bus(folder: Path, text: str) -> Bus:
    """Return the bus of a text, whose only findings are missing heartbeats."""
    (folder / "net.toml").write_text(text, encoding="utf-8")
    shutil.copy(BASE, folder / "board.eds")
    result = load(folder / "net.toml", root=folder)
    assert {d.code for d in result.diagnostics} <= {"EDS0711"}
    assert result.bus is not None
    return result.bus


def pdos(of: Bus, node: str) -> dict[str, Pdo]:
    [found] = [n for n in of.nodes if n.name == node]
    return {f"{p.direction}{p.number}": p for p in found.device.pdos}


LINKED = """
[bus]
bit_rate = 500
sync = 0.01
heartbeat = 0.1

[device.board]
eds = "board.eds"
name = "Board"
ports = "object"
parameters = ["2000", "2001:1"]

[device.board.values]
"2000" = 7
"1600:0" = 1

[device.board.factors]
"2001:1" = 0.5

[node.one]
device = "board"
id = 1

[node.one.values]
"2000" = 9
"1800:2" = 4

[node.two]
device = "board"
id = 0x0A

[[link]]
from = "one.tpdo1"
to = "two.rpdo1"
"""


def test_values_and_links(tmp_path: Path) -> None:
    found = bus(tmp_path, LINKED)
    one, two = found.nodes
    assert (found.name, found.manager) == ("net", 127)
    assert (one.kind.module, one.kind.ports) == ("Board", "object")
    assert one.kind.parameters == ((0x2000, 0), (0x2001, 1))
    assert one.kind.factors == (((0x2001, 1), 0.5),)
    assert one.device.find(0x2000).current == 9  # type: ignore[union-attr]
    assert two.device.find(0x2000).current == 7  # type: ignore[union-attr]
    assert dict(one.values)[0x1800, 2] == 4
    assert two.id == 10
    assert found.links == (PdoLink(("one", 1), ("two", 1)),)
    assert pdos(found, "one")["tpdo1"].cob_id == 0x40000181
    assert pdos(found, "two")["rpdo1"].cob_id == 0x181
    assert dict(two.values)[0x1400, 1] == 0x181
    assert pdos(found, "two")["rpdo1"].bits == 8


def test_messages(tmp_path: Path) -> None:
    found = bus(tmp_path, LINKED)
    sent = {m.name: (m.identifier, m.octets, m.period) for m in messages(found)}
    assert sent == {
        "NMT": (0, 2, 10**9),
        "SYNC": (0x80, 0, 10_000_000),
        "manager heartbeat": (0x77F, 1, 100_000_000),
        "one.tpdo1": (0x181, 1, 40_000_000),
        "one.rpdo1": (0x201, 1, 10_000_000),
        "two.tpdo1": (0x18A, 1, 10_000_000),
        "one emergency": (0x81, 8, 10**9),
        "one SDO request": (0x601, 8, 10**9),
        "one SDO answer": (0x581, 8, 10**9),
        "two emergency": (0x8A, 8, 10**9),
        "two SDO request": (0x60A, 8, 10**9),
        "two SDO answer": (0x58A, 8, 10**9),
    }
    queued = {m.name for m in messages(found) if m.queue}
    assert queued == {
        *("NMT", "SYNC", "manager heartbeat", "one.rpdo1"),
        *("one SDO request", "two SDO request"),
    }
    assert {m.name for m in messages(found) if m.trigger} == {"one.tpdo1"}
    written = {("one", 1): Writing(0.002, 0.001)}
    rpdo = next(m for m in messages(found, written) if m.name == "one.rpdo1")
    assert (rpdo.period, rpdo.jitter) == (2_000_000, 1_000_000)


@pytest.mark.parametrize("path", BUSES, ids=lambda path: path.stem)
def test_our_own(path: Path) -> None:
    result = load(path, root=ROOT)
    assert result.diagnostics == ()
    assert result.bus is not None
    sent = messages(result.bus)
    assert 0 < bus_load(sent, result.bus.bit_rate) < 1
    for timing in response_times(sent, result.bus.bit_rate):
        assert timing.response is not None
        assert timing.transmission < timing.response <= timing.message.period


def test_ours_are_these() -> None:
    assert [path.stem for path in BUSES] == ["fourx", "pdo_linking", "rh3_beego"]


def test_a_device_with_errors(tmp_path: Path) -> None:
    (tmp_path / "net.toml").write_text(LINKED, encoding="utf-8")
    (tmp_path / "board.eds").write_text("[2000]\nParameterName=Speed\n")
    result = load(tmp_path / "net.toml", root=tmp_path)
    assert result.bus is None
    assert "EDS0304" in [d.code for d in result.diagnostics]
    (tmp_path / "board.eds").unlink()
    result = load(tmp_path / "net.toml", root=tmp_path)
    [missing] = [d for d in result.diagnostics if d.code == "EDS0001"]
    [named] = missing.related
    assert LINKED.splitlines()[named.span.line - 1] == 'eds = "board.eds"'
    assert [d.code for d in load(tmp_path / "no.toml", root=tmp_path).diagnostics] == [
        "EDS0700"
    ]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("sync = 0.01", "sync = inf"),
        ("sync = 0.01", "sync = nan"),
        ("id = 1", "id = 1e0"),
        ("[node.one]", "[node.'']"),
        ('"2000" = 9', '"2000" = [9]'),
        ("[[link]]", "[link]"),
        ("[bus]", "[bus.x]"),
        ('"2000" = 9', '"2000" = ' + "9" * 5000),
        ('"2000" = 9', '"2000" = 0x' + "9" * 5000),
        ("id = 1", "id = 0x" + "9" * 5000),
    ],
)
def test_odd_content(tmp_path: Path, old: str, new: str) -> None:
    text = LINKED.replace(old, new)
    (tmp_path / "net.toml").write_text(text, encoding="utf-8")
    shutil.copy(BASE, tmp_path / "board.eds")
    result = load(tmp_path / "net.toml", root=tmp_path)
    assert result.bus is None
    assert {d.code for d in result.diagnostics} <= {"EDS0700", "EDS0701", "EDS0704"}


def test_names_of_nodes_that_differ_in_case_only(tmp_path: Path) -> None:
    shutil.copy(BASE, tmp_path / "board.eds")
    lines = [*LINKED.splitlines(), "[node.ONE]", 'device = "board"', "id = 99"]
    (tmp_path / "net.toml").write_text("\n".join(lines), encoding="utf-8")
    found = load(tmp_path / "net.toml", root=tmp_path).diagnostics
    at = lines.index("[node.ONE]") + 1
    assert [d.span.line for d in found if d.code == "EDS0701" and d.span] == [at]
    text = "\n".join(lines).replace("[bus]", "[bus]\ndcf = false", 1)
    (tmp_path / "net.toml").write_text(text, encoding="utf-8")
    assert load(tmp_path / "net.toml", root=tmp_path).bus is not None


@pytest.mark.parametrize(
    "text", ["two\nlines", "\r", "\0", "a\0b", " before", "behind\t"]
)
def test_texts_that_no_description_can_hold(tmp_path: Path, text: str) -> None:
    eds = BASE.read_text(encoding="utf-8")
    eds += "\n[2010]\nParameterName=Label\nObjectType=0x7\nDataType=0x0009\nAccessType=rw\n"
    (tmp_path / "board.eds").write_text(eds, encoding="utf-8")
    (tmp_path / "net.toml").write_text(
        '[bus]\nbit_rate = 500\n[device.board]\neds = "board.eds"\n'
        f'[node.one]\ndevice = "board"\nid = 1\n[node.one.values]\n"2010" = {json.dumps(text)}\n',
        encoding="utf-8",
    )
    errors = [
        d
        for d in load(tmp_path / "net.toml", root=tmp_path).diagnostics
        if d.severity is Severity.ERROR
    ]
    assert [(d.code, d.span.line) for d in errors if d.span] == [("EDS0704", 9)]


def test_a_unit_that_no_description_can_hold(tmp_path: Path) -> None:
    shutil.copy(BASE, tmp_path / "board.eds")
    units = '[device.board.units]\n"2000" = "m\\n[x]"\n\n[device.board.factors]'
    text = LINKED.replace("[device.board.factors]", units)
    (tmp_path / "net.toml").write_text(text, encoding="utf-8")
    found = load(tmp_path / "net.toml", root=tmp_path).diagnostics
    assert "EDS0701" in {d.code for d in found}


@pytest.mark.parametrize(
    ("described", "own", "expected"),
    [(5000, "", 5), (0, "", 2), (5000, "boot_timeout = 1.5", 1.5), (1 << 31, "", 3600)],
)
def test_the_boot_time_of_a_device(
    tmp_path: Path, described: int, own: str, expected: float
) -> None:
    text = BASE.read_text(encoding="utf-8")
    text += "\n[1F89]\nParameterName=Boot time\nObjectType=0x7\nDataType=0x0007\n"
    text += f"AccessType=rw\nDefaultValue={described}\n"
    (tmp_path / "board.eds").write_text(text, encoding="utf-8")
    (tmp_path / "net.toml").write_text(
        '[bus]\nbit_rate = 500\n[device.board]\neds = "board.eds"\n'
        f'[node.one]\ndevice = "board"\nid = 1\n{own}\n',
        encoding="utf-8",
    )
    found = load(tmp_path / "net.toml", root=tmp_path).bus
    assert found is not None
    assert found.nodes[0].boot_timeout == expected


@pytest.mark.parametrize(
    ("values", "found"),
    [
        ({}, set()),
        ({"1400:1": 0x201}, set()),
        ({"1600:0": 2}, set()),
        ({"1600:0": 1}, set()),
        ({"1600:2": 0x23460008}, {"EDS0705"}),
        ({"1400:1": 0x201, "1600:2": 0x23460008}, {"EDS0705"}),
    ],
)
def test_mistakes_of_pdos_that_are_not_valid(
    tmp_path: Path, values: dict[str, int], found: set[str]
) -> None:
    text = BASE.read_text(encoding="utf-8")
    board = text.replace("$NODEID+0x200", "0x80000000").replace(
        "DefaultValue=0x00050008", "DefaultValue=0x23450008"
    )
    (tmp_path / "board.eds").write_text(board, encoding="utf-8")
    lines = "".join(f'"{key}" = {value}\n' for key, value in values.items())
    (tmp_path / "net.toml").write_text(
        f'[bus]\nbit_rate = 500\n[device.board]\neds = "board.eds"\n'
        f'[node.one]\ndevice = "board"\nid = 1\n[device.board.values]\n{lines}',
        encoding="utf-8",
    )
    result = load(tmp_path / "net.toml", root=tmp_path)
    codes = {d.code for d in result.diagnostics}
    assert "EDS0501" in codes
    assert {code for code in codes if code >= "EDS07"} == {*found, "EDS0711"}
    assert (result.bus is None) == bool(found)


@pytest.mark.parametrize(
    ("values", "wrong"),
    [
        ({"1800:1": 0x80}, "two.tpdo1 has the CAN identifier of SYNC"),
        (
            {"1400:1": 0x81},
            "two.rpdo1 has the CAN identifier of the emergency messages of one",
        ),
        ({"1801:1": 0x40000182}, "two.tpdo2 has the CAN identifier of two.tpdo1, 182h"),
    ],
)
def test_clashes(tmp_path: Path, values: dict[str, int], wrong: str) -> None:
    text = BASE.read_text(encoding="utf-8")
    first = text.index("[1800]")
    pdo = text[first : text.index("[2000]")]
    second = pdo.replace("[1800", "[1801").replace("[1A00", "[1A01")
    (tmp_path / "board.eds").write_text(
        text + second.replace("$NODEID+0x40000180", "$NODEID+0x40000280"),
        encoding="utf-8",
    )
    lines = "".join(f'"{key}" = {value}\n' for key, value in values.items())
    (tmp_path / "net.toml").write_text(
        '[bus]\nbit_rate = 500\n[device.board]\neds = "board.eds"\n'
        '[node.one]\ndevice = "board"\nid = 1\n'
        f'[node.two]\ndevice = "board"\nid = 2\n[node.two.values]\n{lines}',
        encoding="utf-8",
    )
    result = load(tmp_path / "net.toml", root=tmp_path)
    errors = [d.message for d in result.diagnostics if d.code == "EDS0706"]
    assert errors == [wrong]


def test_published_schema(update_golden: bool) -> None:
    file = ROOT / "docs/bus.schema.json"
    text = json.dumps(SCHEMA, indent=2) + "\n"
    if update_golden:
        file.write_text(text, encoding="utf-8")
    assert file.read_text(encoding="utf-8") == text
