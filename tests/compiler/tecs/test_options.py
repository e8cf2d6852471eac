"""The options in the argument of RTCPlugin, and the consistency of joins."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import pytest
from boards import SERVER, emit, imported, joined, texts, write

from rtgen.api import read
from rtgen.compiler.lowering.tecs.options import RtcOptions
from rtgen.compiler.lowering.tecs.rules import UNKNOWN_OPTION
from rtgen.compiler.typemap.tecs.idl import Widths
from rtgen.facts.opaque_rpc import FIRST_PORT, MAX_TIMEOUT
from rtgen.runtime.opaque_rpc import (
    REQUEST_LIMIT,
    Codec,
    LinkSettings,
    Order,
    RpcError,
    TcpChannel,
    TcpServer,
    ends,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.serial import BAUDRATE


def text_of(folder: Path, name: str, options: str, count: int = 1) -> str:
    text = joined(SERVER, *["sServer"] * count, options=options)
    emission, findings = emit(folder, {"server.cdl": text})
    assert not findings
    return texts(emission.artifacts)[f"robots/tecs/server/{name}"]


def test_the_defaults_are_those_of_the_runtime() -> None:
    """Neither side may import the other, so each has them."""

    class Silent(Codec):
        ids: ClassVar[dict[str, int]] = {}

    usual, link, codec = RtcOptions(), LinkSettings(), Silent()
    assert usual.baudrate == BAUDRATE
    assert usual.limit == REQUEST_LIMIT
    assert (usual.address, usual.timeout) == (link.ipaddr, link.timeout)
    assert str(FIRST_PORT) == link.port
    assert MAX_TIMEOUT == ends.MAX_TIMEOUT
    assert (usual.tdr, usual.encoding) == (codec.tdr.order, codec.encoding)


@pytest.mark.parametrize("order", ["network", "little", "big"])
def test_the_usual_widths_are_those_of_the_runtime(order: Order) -> None:
    widths, tdr = RtcOptions(tdr=order).widths, make_tdr(order)
    assert widths == Widths(
        tdr.short_bits, tdr.int_bits, tdr.long_bits, tdr.intptr_bits
    )


@pytest.mark.parametrize(
    ("options", "code", "message", "place", "hint"),
    [
        ("prot=1", "CDL1001", "no option prot", "prot", "did you mean port?"),
        ("longbits=64", "CDL1001", "no option", "longbits", "did you mean longBits?"),
        ("quux=1", "CDL1001", "no option quux", "quux", "the options are tdr, reply"),
        ("port=http", "CDL1002", "from 1 to 65535", "http", None),
        ("port=0", "CDL1002", "from 1 to 65535", "0", None),
        ("longBits=48", "CDL1002", "16, 32 or 64", "48", None),
        (
            "tdr=middle",
            "CDL1002",
            "network, little, big",
            "middle",
            "the default is network",
        ),
        ("reply=late", "CDL1002", "tecsgen, paper", "late", None),
        ("timeout=-1", "CDL1002", "above 0", "-1", "the default is 1.0"),
        ("timeout=1e9", "CDL1002", "at most 1000000", "1e9", None),
        ("timeout=nan", "CDL1002", "above 0", "nan", None),
        ("encoding=utf-16", "CDL1002", "an encoding", "utf-16", None),
        ("encoding=klingon", "CDL1002", "an encoding", "klingon", None),
        (
            "PPAllocatorSize=0",
            "CDL1002",
            "whole number above 0",
            "0",
            "the default is 4096",
        ),
        ("name=two words", "CDL1002", "letters, digits", "two words", None),
        ("array=list", "CDL1002", "sequence, any", "list", None),
        ("baudrate=fast", "CDL1002", "whole number", "fast", "the default is 115200"),
    ],
)
def test_wrong_options(
    tmp_path: Path, options: str, code: str, message: str, place: str, hint: str | None
) -> None:
    argument = f"tdr=network, {options}"
    text = joined(SERVER, "sServer", options=argument)
    emission, (finding,) = emit(tmp_path, {"server.cdl": text})
    assert not emission.artifacts
    assert finding.code == code
    assert message in finding.message
    assert (hint or "") in (finding.hint or "")
    assert finding.span is not None
    line = text.split("\n")[finding.span.line - 1]
    assert line[finding.span.column - 1 : finding.span.end_column - 1] == place


def test_all_wrong_options_are_reported(tmp_path: Path) -> None:
    text = joined(SERVER, "sServer", options="port=x, quux=1, tdr=y")
    _, findings = emit(tmp_path, {"server.cdl": text})
    assert [f.code for f in findings] == ["CDL1002", "CDL1001", "CDL1002"]


def test_every_option_is_explained() -> None:
    for name in (f.metadata["name"] for f in RtcOptions.__dataclass_fields__.values()):
        assert f"`{name}`" in UNKNOWN_OPTION.explanation


def test_options_of_tecsgen_are_left_to_it(tmp_path: Path) -> None:
    plain = text_of(tmp_path, "server_marshaller.py", "")
    left = text_of(tmp_path, "server_marshaller.py", "taskPriority=11, stackSize=4096")
    assert left.split("\n")[1:] == plain.split("\n")[1:]


@pytest.mark.parametrize(
    ("options", "codec"),
    [
        ("", "ServerCodec()"),
        ("tdr=little", 'ServerCodec(make_tdr("little"))'),
        ("longBits=64", 'ServerCodec(make_tdr("network", long_bits=64))'),
        ("reply=paper, PPAllocatorSize=99", "ServerCodec(limit=99)"),
        ("encoding=cp932", 'ServerCodec(encoding="cp932")'),
    ],
)
def test_codecs(tmp_path: Path, options: str, codec: str) -> None:
    for name in ("server_marshaller.py", "server_server.py"):
        assert f"codec or {codec}\n" in text_of(tmp_path, name, options)


BULK = "signature sBulk { int32_t put( [in,size_is(n)] const uint8_t *d, [in] int32_t n ); };"


@pytest.mark.parametrize(("options", "limit"), [("", 4096), ("PPAllocatorSize=9", 9)])
def test_servers_take_as_much_as_the_option_says(
    tmp_path: Path, options: str, limit: int
) -> None:
    text = joined(BULK, "sBulk", options=options)
    emission, findings = emit(tmp_path, {"bulk.cdl": text})
    assert not findings
    write(tmp_path, emission.artifacts)
    names = ("robots.tecs.bulk.bulk_server", "robots.tecs.bulk.bulk_marshaller")
    with imported(tmp_path, *names) as (server, marshaller):

        class Target(server.BulkTarget):  # type: ignore[name-defined, misc]
            def put(self, d: bytes, n: int) -> int:
                return len(d)

        with TcpServer(server.BulkUnmarshaller(Target())) as listening:
            bulk = marshaller.BulkProxy(TcpChannel(*listening.address))
            assert bulk.put(bytes(limit), limit) == limit
            with pytest.raises(RpcError):
                bulk.put(bytes(limit + 1), limit + 1)
            bulk.channel.close()


@pytest.mark.parametrize(
    ("options", "lines"),
    [
        ("", ["mode2", "conf.mode1.port: none", "conf.mode2.port: 8931"]),
        ("port=9000", ["mode2", "conf.mode2.port: 9000"]),
        ("port=9000+$count$", ["mode2", "conf.mode2.port: 9000"]),
        (
            "address=10.0.0.7",
            ["conf.mode2.ipaddr: 10.0.0.7", "conf.mode1.ipaddr: none"],
        ),
        (
            "device=/dev/ttyUSB0, baudrate=9600, timeout=2.5",
            [
                "mode1",
                "conf.mode1.type: SERIA",
                "conf.mode1.port: /dev/ttyUSB0",
                "conf.mode1.baudrate: 9600",
                "conf.mode1.timeout: 2.5",
                "conf.mode2.baudrate: none",
                "conf.mode2.type: TCP",
            ],
        ),
    ],
)
def test_configuration_files(tmp_path: Path, options: str, lines: list[str]) -> None:
    text = text_of(tmp_path, "OpaqueRpcCommunication0.conf", options)
    for line in lines:
        wanted = f"configuration.active_config: {line}" if "." not in line else line
        assert f"{wanted}\n" in text
    assert text.startswith("configuration.active_config: ")


def test_joins_are_numbered(tmp_path: Path) -> None:
    text = text_of(tmp_path, "OpaqueRpcCommunication2.conf", "", count=3)
    assert "conf.mode2.port: 8933\n" in text


def test_a_name_for_the_communication_rtc(tmp_path: Path) -> None:
    assert "8931" in text_of(tmp_path, "Left.conf", "name=Left")


def test_joins_that_differ(tmp_path: Path) -> None:
    text = joined(SERVER, "sServer", options="tdr=little")
    more = joined("", "sServer", options="tdr=big, reply=paper")
    for name in ("tServer0", "tClient0", "Server0", "Client0"):
        more = more.replace(f" {name} ", f" Other{name} ").replace(
            f"{name}.", f"Other{name}."
        )
    _, (finding,) = emit(tmp_path, {"server.cdl": text + more})
    assert finding.code == "CDL1004"
    assert "differ in tdr, reply" in finding.message


def test_signatures_of_one_name(tmp_path: Path) -> None:
    text = (
        "namespace nA { signature sOne { ER f( void ); }; };\n"
        "namespace nB { signature sOne { ER f( void ); }; };\n"
    )
    _, findings = emit(tmp_path, {"a.cdl": joined(text, "nA::sOne", "nB::sOne")})
    assert [f.code for f in findings] == ["CDL1005"]


def test_component_types_of_one_name(tmp_path: Path) -> None:
    text = joined(SERVER, "sServer")
    emission, (finding,) = emit(tmp_path, {"left.cdl": text, "right.cdl": text})
    assert finding.code == "CDL1006"
    factories = emission.components.factories
    for name, target in (
        ("ServerMarshaller", "robots.tecs.left.server_marshaller:ServerMarshaller"),
        ("ServerClient", "nodes.server_client:ServerClient"),
    ):
        assert factories[name] == target
    skeleton = texts(emission.artifacts)["nodes/server_client.py"]
    assert "from robots.tecs.left.server_marshaller import" in skeleton


def test_components_of_definitions_that_are_made_for_boards_too(tmp_path: Path) -> None:
    names = ("ServerMarshaller", "ServerClient", "OpaqueRpcCommunication")
    idl, cdl = tmp_path / "own.idl", tmp_path / "server.cdl"
    declared = (
        f'@rtc(category="A", vendor="b")\ncomponent {name} {{}};\n'
        for name in (*names, "Other")
    )
    idl.write_text("".join(declared), encoding="utf-8")
    cdl.write_text(joined(SERVER, "sServer"), encoding="utf-8")
    findings = read([idl, cdl], lowered=True).diagnostics
    taken = {d.span.line: d.message for d in findings if d.span and d.code == "CDL1006"}
    assert sorted(taken) == [2, 4, 6]
    assert all(name in taken[line] for line, name in zip((2, 4, 6), names, strict=True))


@pytest.mark.parametrize(
    ("parameters", "early"),
    [
        ("[out, size_is( 4 ), count_is( *n )] int8_t *a, [out] int32_t *n", "n"),
        ("[out] int32_t *n, [out, size_is( 4 ), count_is( *n+1 )] int8_t *a", "n"),
        (
            "[in] int32_t m, [out, size_is( m ), count_is( *p/2 )] int8_t *a,"
            " [out] uint8_t *p",
            "p",
        ),
        ("[out, size_is( 4 ), count_is( *n )] int8_t *a, [inout] int32_t *n", None),
        ("[out, size_is( n )] int8_t *a, [in] int32_t n", None),
        ("[inout, size_is( 4 ), count_is( *n )] int8_t *a, [inout] int32_t *n", None),
    ],
)
def test_a_size_that_a_board_reads_before_the_call(
    tmp_path: Path, parameters: str, early: str | None
) -> None:
    text = f"signature sOne {{ ER f( {parameters} ); }};\n"
    _, findings = emit(tmp_path, {"a.cdl": joined(text, "sOne")})
    assert [f.code for f in findings] == (["CDL1008"] if early else [])
    assert all(f"read {early!r} before the call" in f.message for f in findings)


def test_callers_through_a_region_share_a_channel(tmp_path: Path) -> None:
    cells = "".join(
        f"  cell tClient Client{i} {{ cServer = rBoard::Server.eServer; }};\n"
        for i in (0, 1)
    )
    text = (
        f"{SERVER}celltype tServer {{ entry sServer eServer; }};\n"
        "[active] celltype tClient { call sServer cServer; };\n"
        "[linkunit] region rBoard { cell tServer Server {}; };\n"
        '[linkunit, to_through(rBoard,RTCPlugin,"port=9001")]\n'
        f"region rRobot {{\n{cells}}};\n"
    )
    emission, findings = emit(tmp_path, {"board.cdl": text})
    assert not findings
    files = [path for path in texts(emission.artifacts) if path.endswith(".conf")]
    assert files == ["robots/tecs/board/OpaqueRpcCommunication0.conf"]


def test_the_spelling_of_the_paper(tmp_path: Path) -> None:
    text = joined(SERVER, "sServer").replace("RTCPlugin", "RTCPlug-in")
    emission, _ = emit(tmp_path, {"server.cdl": text})
    assert "robots/tecs/server/Server.idl" in texts(emission.artifacts)


CELLS = """signature sOne { ER f( void ); };
celltype tServer { entry sOne eOne; };
celltype tClient { call sOne cOne; };
cell tServer Left {}; cell tServer Right {};
"""


@pytest.mark.parametrize(
    ("options", "messages"),
    [
        (("", ""), []),
        (("port=8932", "port=8931"), []),
        (("port=8932", ""), ["127.0.0.1:8932 is the channel of User0.cOne, too"]),
        (("port=8932", "port=8932, address=far"), []),
        (("device=COM1", "device=COM1"), ["COM1 is the channel of User0.cOne, too"]),
        (("device=COM1, port=9", "port=9"), []),
        (("name=Left", "name=Left"), ["name cannot be 'Left': another join has it"]),
        (
            ("name=OpaqueRpcCommunication1", ""),
            ["name cannot be 'OpaqueRpcCommunication1': another join has it"],
        ),
    ],
)
def test_joins_with_one_channel(
    tmp_path: Path, options: tuple[str, str], messages: list[str]
) -> None:
    cells = "".join(
        f'cell tClient User{n} {{ [through( RTCPlugin, "{text}" )] cOne = {to}.eOne; }};\n'
        for n, (text, to) in enumerate(zip(options, ("Left", "Right"), strict=True))
    )
    _, findings = emit(tmp_path, {"a.cdl": CELLS + cells})
    assert [f.message for f in findings] == messages
    assert all(f.span and f.span.line == 6 and f.hint for f in findings)
    assert all(f.related[0].span.line == 5 for f in findings)


def test_a_join_through_the_plug_in_twice(tmp_path: Path) -> None:
    through = 'through( RTCPlugin, "" )'
    cell = f"cell tClient User {{ [{through}, {through}] cOne = Left.eOne; }};\n"
    _, (finding,) = emit(tmp_path, {"a.cdl": CELLS + cell})
    assert (finding.code, finding.message) == (
        "CDL1009",
        "User.cOne goes through RTCPlugin twice",
    )
