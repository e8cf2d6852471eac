"""`rtgen rpc list`, `encode` and `decode`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest
from json_schemas import valid

from rtgen.cli import run

Rpc: TypeAlias = Callable[..., str]

CDL = """
struct tagPoint { int16_t x; int16_t y; };
signature sMove {
  ER go( [in] struct tagPoint p, [out] int32_t *id );
  ER text( [out,string(cap)] char_t *s, [in] int32_t cap );
  ER fill( [out,size_is(n)] uint16_t *v, [in] int16_t n );
  ER maybe( [out,nullable] int8_t *a, [inout,nullable] int16_t *b );
  [oneway] void stop( void );
  ER load( [in,size_is(n)] const uint16_t *v, [in] int16_t n );
};
namespace nArm { signature sArm { void grip( [in] enum eKind k ); long_t far( void ); }; };
"""


@pytest.fixture
def rpc(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Rpc:
    path = tmp_path / "move.cdl"
    path.write_text(CDL.replace("namespace", "enum eKind { A };\nnamespace"), "utf-8")

    def called(command: str, *arguments: str, code: int = 0) -> str:
        assert run(["rpc", command, "--cdl", str(path), *arguments]) == code
        captured = capsys.readouterr()
        return captured.err if code else captured.out

    return called


def test_list(rpc: Rpc) -> None:
    lines = rpc("list").splitlines()
    assert lines[:2] == [
        "sMove",
        "    1  ER go([in] struct tagPoint p, [out] int32_t* id)",
    ]
    assert "    5  [oneway] void stop(void)" in lines
    assert lines[7] == "nArm::sArm"
    assert lines[-1].startswith("       not transferable: enum")
    listed = valid(rpc("list", "--json"), "rpc.schema.json", "list")["signatures"]
    assert [each["name"] for each in listed] == ["sMove", "nArm::sArm"]
    move, arm = listed
    assert [(f["id"], f["name"]) for f in move["functions"]][4] == (5, "stop")
    assert move["problems"] == []
    assert [f"       {text}" for text in arm["problems"]] == lines[-1:]


def test_encode_and_decode(rpc: Rpc) -> None:
    args = {"p": {"x": 1, "y": -1}}
    data = rpc("encode", "sMove.go", "--request", json.dumps(args)).strip()
    assert data == "672a00010001ffff5a3c"
    assert json.loads(rpc("decode", "sMove.go", "--request", data)) == args
    reply = {"return": -17, "outs": {"id": 5}}
    data = rpc("encode", "sMove.go", "--reply", json.dumps(reply)).strip()
    assert data == "561effffffef000000056d5e"
    assert json.loads(rpc("decode", "sMove.go", "--reply", data)) == reply
    skipped = '{"return": -68, "outs": null}'
    data = rpc("encode", "sMove.go", "--reply", skipped).strip()
    assert data == "561effffffbc6d5e"
    assert rpc("decode", "sMove.go", "--reply", data) == f"{skipped}\n"


def test_requests_may_be_longer_than_a_board_takes(rpc: Rpc) -> None:
    args = {"v": [7] * 5000, "n": 5000}
    data = rpc("encode", "sMove.load", "--request", json.dumps(args)).strip()
    assert len(data) == 2 * (4 + 2 + 2 * 5000 + 2)
    assert json.loads(rpc("decode", "sMove.load", "--request", data)) == args


def test_options_of_the_peer(rpc: Rpc) -> None:
    reply = '{"return": 1, "outs": {"id": 2}}'
    paper = ("--reply-order", "paper", "--tdr", "little")
    data = rpc("encode", "sMove.go", *paper, "--reply", reply)
    assert data == "1e5602000000010000005e6d\n"


@pytest.mark.parametrize(
    ("function", "reply", "hexes"),
    [
        (
            "text",
            {"return": 0, "outs": {"s": "ab"}},
            "561e00000000000000046162000 06d5e",
        ),
        ("fill", {"return": 0, "outs": {"v": [1, 2]}}, "561e00000000000100026d5e"),
        ("fill", {"return": 0, "outs": {"v": []}}, "561e000000006d5e"),
        ("maybe", {"return": 0, "outs": {"a": 1, "b": 2}}, "561e000000000100026d5e"),
        ("maybe", {"return": 0, "outs": {"a": 1, "b": None}}, "561e00000000016d5e"),
        ("maybe", {"return": 0, "outs": {"a": None, "b": None}}, "561e000000006d5e"),
    ],
)
def test_a_reply_without_its_request(
    rpc: Rpc, function: str, reply: dict[str, object], hexes: str
) -> None:
    data = hexes.replace(" ", "")
    name = f"sMove.{function}"
    assert rpc("encode", name, "--reply", json.dumps(reply)) == f"{data}\n"
    assert json.loads(rpc("decode", name, "--reply", data)) == reply


def test_a_reply_to_its_request(rpc: Rpc) -> None:
    reply = '{"return": 0, "outs": {"s": "ab"}}'
    data = rpc("encode", "sMove.text", "--request", '{"cap": 3}', "--reply", reply)
    assert data == "561e00000000000000036162006d5e\n"
    request = "672a0002000000025a3c"
    wrong = ("--request", request, "--reply", data.strip())
    error = rpc("decode", "sMove.text", *wrong, code=2)
    assert "a size of 3, at most 2 allowed (E_PAR)" in error


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("encode", "sMove.g", "--request", "{}"), "no function 'g'"),
        (("encode", "sMoves.go", "--request", "{}"), "did you mean 'sMove'?"),
        (("encode", "go", "--request", "{}"), "SIGNATURE.FUNCTION"),
        (("encode", "sMove.go", "--request", "{"), "'{' is not JSON"),
        (("encode", "sMove.go", "--request", '{"p": 1, "p": 2}'), "'p' is there twice"),
        (
            ("encode", "sMove.go", "--request", '{"p": {"x": 1, "x": 2}}'),
            "'x' is there",
        ),
        (("encode", "sMove.go", "--request", "{}"), "'p' is missing"),
        (("check", "h:1", "sMove", "--timeout", "inf"), "a positive number of seconds"),
        (("check", "h:1", "sMove", "--timeout", "nan"), "a positive number of seconds"),
        (("encode", "sMove.go", "--timeout", "1"), "No such option '--timeout'"),
        (("list", "--tdr", "little"), "No such option '--tdr'"),
        (("encode", "sMove.go"), "give --request or --reply"),
        (("encode", "sMove.stop", "--reply", "{}"), "stop is oneway"),
        (("decode", "sMove.go"), "give --request or --reply"),
        (("decode", "sMove.go", "--request", "67zz"), "is not hex: write hex digits"),
        (("decode", "sMove.go", "--request", "672a00025a3c"), "another function"),
        (("decode", "sMove.go", "--request", "0000"), "2 bytes are missing"),
        (("decode", "sMove.stop", "--request", "672a00056d5e00"), "1 bytes are left"),
        (("decode", "sMove.fill", "--reply", "561e"), "bytes are missing"),
        (("encode", "nArm::sArm.far", "--request", "{}"), "enum"),
    ],
)
def test_what_is_refused(rpc: Rpc, arguments: tuple[str, ...], message: str) -> None:
    assert message in rpc(*arguments, code=2)


def test_an_error_in_the_definitions_is_reported_at_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "wrong.cdl"
    path.write_text("signature sA { void f( [in] nothing_t x ); };", "utf-8")
    assert run(["rpc", "list", "--cdl", str(path)]) == 2
    assert "wrong.cdl:1:" in capsys.readouterr().err
