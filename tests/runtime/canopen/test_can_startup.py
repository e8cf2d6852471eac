"""Values written to nodes at start-up, and their order."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import pytest

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.bus import load
from rtgen.compiler.layouts.can_startup import StartWrite, concise_dcf, start_up
from rtgen.compiler.layouts.can_values import CanValueError, octets
from rtgen.compiler.model.can_bus import Bus
from rtgen.compiler.model.canopen import DataType, NodeRelative
from rtgen.runtime.canopen.values import decode

SAMPLER = (
    Path(__file__).parents[2] / "golden/cases/canopen_devices/input/specs/sampler.eds"
)
HEAD = """
[bus]
bit_rate = 500
[device.sampler]
eds = "sampler.eds"
[node.first]
device = "sampler"
id = 3
"""

Written = list[tuple[str, str]]


@pytest.fixture
def bus(tmp_path: Path) -> Callable[..., Bus]:
    """Return a reader of a bus with one sampler and further text."""

    def make(text: str, change: Callable[[str], str] = str) -> Bus:
        eds = change(SAMPLER.read_text(encoding="utf-8"))
        (tmp_path / "sampler.eds").write_text(eds, encoding="utf-8")
        (tmp_path / "bus.toml").write_text(HEAD + text, encoding="utf-8")
        result = load(tmp_path / "bus.toml", root=tmp_path)
        assert not has_errors(result.diagnostics), result.diagnostics
        assert result.bus is not None
        return result.bus

    return make


@pytest.fixture
def written(bus: Callable[..., Bus]) -> Callable[..., Written]:
    """Return a function for the writes to the node: (object, octets)."""

    def make(values: str = "", change: Callable[[str], str] = str) -> Written:
        text = f"[device.sampler.values]\n{values}"
        return shown(start_up(bus(text, change).nodes[0]))

    return make


def shown(writes: tuple[StartWrite, ...]) -> Written:
    return [
        (f"{w.variable.index:04X}:{w.variable.subindex:X}", w.value.hex())
        for w in writes
    ]


def test_nothing_is_written_to_a_device_that_is_as_it_should_be(
    written: Callable[..., Written],
) -> None:
    assert written() == []


def test_what_is_asked_for_is_written_though_it_is_the_default(
    written: Callable[..., Written],
) -> None:
    assert written('"2020" = 1500') == [("2020:0", "dc050000")]


def test_the_heartbeat_is_written_though_it_is_the_default(
    written: Callable[..., Written],
) -> None:
    def beating(eds: str) -> str:
        head, mark, rest = eds.partition("[1017]")
        return head + mark + rest.replace("DefaultValue=0", "DefaultValue=250", 1)

    assert written(change=beating) == [("1017:0", "fa00")]


def test_the_heartbeat_comes_before_those_that_are_consumed(
    written: Callable[..., Written],
) -> None:
    assert written('"1016:1" = 0x7F0258\n"1017" = 100\n"2001" = true') == [
        ("1017:0", "6400"),
        ("1016:1", "58027f00"),
        ("2001:0", "01"),
    ]


def test_a_pdo_is_switched_off_mapped_anew_and_switched_on(
    written: Callable[..., Written],
) -> None:
    writes = written(
        '"2020" = 1\n"1800:5" = 250\n"1A00:0" = 2\n"1A00:1" = 0x20050008\n'
        '"1A00:2" = 0x20130020'
    )
    assert writes == [
        ("1800:1", "830100c0"),
        ("1800:5", "fa00"),
        ("1A00:0", "00"),
        ("1A00:1", "08000520"),
        ("1A00:2", "20001320"),
        ("1A00:0", "02"),
        ("1800:1", "83010040"),
        ("2020:0", "01000000"),
    ]


def test_all_entries_are_written_though_only_one_changes(
    written: Callable[..., Written],
) -> None:
    writes = written('"1A01:1" = 0x10010008')
    assert [place for place, _ in writes] == [
        *("1801:1", "1A01:0", "1A01:1", "1A01:2", "1A01:3", "1A01:0", "1801:1")
    ]


def test_a_pdo_that_is_switched_off_stays_off(written: Callable[..., Written]) -> None:
    assert written('"1802:1" = "$NODEID+0x80000380"') == [("1802:1", "83030080")]
    writes = written('"1401:2" = 255')
    assert writes == [("1401:1", "03030080"), ("1401:2", "ff")]


def test_a_pdo_that_maps_nothing_stays_off(written: Callable[..., Written]) -> None:
    """Nodes refuse to switch it on: CANopenNode does, with 06090030h."""
    assert written('"1A02:0" = 0') == [("1802:1", "83030080"), ("1A02:0", "00")]


def test_a_pdo_is_off_with_its_own_identifier(written: Callable[..., Written]) -> None:
    """Nodes may refuse a restricted identifier of a service that is off, too."""
    assert written('"1802:1" = 0x80000000') == [("1802:1", "83030080")]


def test_what_a_device_stores_comes_last_and_is_not_read_back(
    bus: Callable[..., Bus],
) -> None:
    store = (
        "[1010]\nParameterName=Store\nObjectType=7\nDataType=7\nAccessType=rw\n\n[2001]"
    )
    made = bus(
        '[node.first.values]\n"1010" = 0x65766173\n"2020" = 1',
        lambda text: text.replace("[2001]", store),
    )
    writes = start_up(made.nodes[0])
    assert shown(writes) == [("2020:0", "01000000"), ("1010:0", "73617665")]
    assert [w.verify for w in writes] == [True, False]


def test_values_of_a_dcf_are_written_unless_they_are_for_no_download(
    tmp_path: Path,
) -> None:
    text = SAMPLER.read_text(encoding="utf-8")
    text = text.replace("DefaultValue=1500\n", "DefaultValue=1500\nParameterValue=7\n")
    text = text.replace(
        "DefaultValue=0.1\n", "DefaultValue=0.1\nParameterValue=2.0\nObjFlags=1\n"
    )
    text = text.replace(
        "DefaultValue=bench\n", "DefaultValue=bench\nParameterValue=bench\n"
    )
    (tmp_path / "sampler.dcf").write_text(text, encoding="utf-8")
    head = HEAD.replace("sampler.eds", "sampler.dcf")
    (tmp_path / "bus.toml").write_text(head, encoding="utf-8")
    made = load(tmp_path / "bus.toml", root=tmp_path).bus
    assert made is not None
    assert shown(start_up(made.nodes[0])) == [("2020:0", "07000000")]


def test_both_ends_of_a_link_get_the_identifier(
    bus: Callable[..., Bus], tmp_path: Path
) -> None:
    text = (
        '[node.second]\ndevice = "sampler"\nid = 4\n'
        '[[link]]\nfrom = "first.tpdo2"\nto = "second.rpdo2"\n'
    )
    first, second = bus(text).nodes
    assert shown(start_up(first))[-1] == ("1801:1", "83020000")
    assert shown(start_up(second))[-1] == ("1401:1", "83020000")


def test_concise_dcf(bus: Callable[..., Bus]) -> None:
    made = bus('[node.first.values]\n"2030" = "left"\n"1017" = 100')
    data = concise_dcf(start_up(made.nodes[0]))
    [count] = struct.unpack_from("<I", data)
    at, entries = 4, []
    for _ in range(count):
        index, subindex, size = struct.unpack_from("<HBI", data, at)
        entries.append((index, subindex, data[at + 7 : at + 7 + size]))
        at += 7 + size
    assert at == len(data)
    assert entries == [(0x1017, 0, b"\x64\x00"), (0x2030, 0, b"left")]


@pytest.mark.parametrize(
    ("data_type", "value", "wanted"),
    [
        (DataType.BOOLEAN, 1, "01"),
        (DataType.INTEGER24, -2, "feffff"),
        (DataType.INTEGER64, -(1 << 63), "0000000000000080"),
        (DataType.UNSIGNED40, (1 << 40) - 1, "ffffffffff"),
        (DataType.UNSIGNED56, 1, "01000000000000"),
        (DataType.REAL32, 1.5, "0000c03f"),
        (DataType.REAL64, -0.5, "000000000000e0bf"),
        (DataType.VISIBLE_STRING, "\u00e9", "e9"),
        (DataType.UNICODE_STRING, "\u5de6", "e65d"),
        (DataType.VISIBLE_CHAR, "A", "41"),
        (DataType.VISIBLE_CHAR, 65, "41"),
        (DataType.OCTET_STRING, b"\0\xff", "00ff"),
        (DataType.DOMAIN, b"", ""),
        (DataType.TIME_OF_DAY, 0x0001_0000_0002, "020000000100"),
        (0x40, b"\1", "01"),
    ],
)
def test_octets(data_type: int, value: int | float | str | bytes, wanted: str) -> None:
    assert octets(data_type, value).hex() == wanted


@pytest.mark.parametrize(
    ("data_type", "value", "reason"),
    [
        (
            DataType.VISIBLE_CHAR,
            "\u5de6",
            "'\u5de6' has a character that is not of Latin-1",
        ),
        (
            DataType.UNICODE_STRING,
            "\ud800",
            r"'\ud800' has a character that is not of UTF-16",
        ),
        (
            DataType.VISIBLE_STRING,
            "\ud800",
            r"'\ud800' has a character that is not of UTF-16",
        ),
        (DataType.UNSIGNED8, 256, "256 is not a value of data type 0005h"),
        (DataType.INTEGER8, 128, "128 is not a value of data type 0002h"),
        (DataType.UNSIGNED16, "text", "'text' is not a value of data type 0006h"),
        (
            DataType.UNSIGNED32,
            NodeRelative(0x80),
            "$NODEID+0x80 depends on the node-id, which is not known",
        ),
        (DataType.REAL32, 1e39, "1e+39 is not a value of data type 0008h"),
        (0x4A, 1, "1 is not a value of data type 004Ah"),
    ],
)
def test_no_octets(
    data_type: int, value: int | float | str | NodeRelative, reason: str
) -> None:
    with pytest.raises(CanValueError) as caught:
        octets(data_type, value)
    assert str(caught.value) == reason


@pytest.mark.parametrize("text", ["drive", "größe", "左", "Ã©"])
def test_texts_are_written_as_the_runtime_reads_them(text: str) -> None:
    assert decode("string", octets(DataType.VISIBLE_STRING, text)) == text
