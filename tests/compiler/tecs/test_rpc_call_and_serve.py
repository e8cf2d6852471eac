"""`rtgen rpc call` with `rtgen rpc serve` in another process, and without a server."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import pytest
from free_ports import free_port

from rtgen.cli import run
from rtgen.runtime.opaque_rpc import E_BOVR, E_OBJ, E_RPC, ERCD, NETWORK
from rtgen.tools.rpc.board import MockBoard, ScriptError
from rtgen.tools.rpc.signatures import CdlFiles, Wire, service_of

Call: TypeAlias = Callable[..., tuple[int, Any]]

CDL = """
struct tagPoint { int16_t x; float32_t y; };
signature sMove {
  ER go( [in] int32_t v, [inout] int16_t *id, [out] uint8_t *o );
  ER fill( [out,size_is(n)] uint16_t *v, [in] int16_t n );
  ER points( [out,size_is(n+1)] struct tagPoint *v, [in] int16_t n );
  ER octets( [out,size_is(max),count_is(*n)] uint8_t *v, [in] int16_t max, [inout] int16_t *n );
  ER text( [out,string(n)] char_t *s, [in] int32_t n );
  int32_t plain( [in,string] const char_t *s );
  [oneway] void stop( void );
};
"""


@pytest.fixture
def cdl(tmp_path: Path) -> Path:
    path = tmp_path / "move.cdl"
    path.write_text(CDL, "utf-8")
    return path


@contextmanager
def serving(cdl: Path, *options: str) -> Iterator[str]:
    """Yield the address of a mock board."""
    command = [sys.executable, "-m", "rtgen", "rpc", "serve", "--cdl", str(cdl)]
    command += ["--signature", "sMove", "--port", "0", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        word, address = process.stdout.readline().split()
        assert word == "listening"
        try:
            yield address
        finally:
            process.terminate()


@pytest.fixture
def call(cdl: Path, capsys: pytest.CaptureFixture[str]) -> Call:
    """Call a function of a board; return exit code and output."""

    def called(address: str, function: str, **arguments: object) -> tuple[int, Any]:
        words = [f"sMove.{function}", json.dumps(arguments)]
        code = run(["rpc", "call", address, "--cdl", str(cdl), *words])
        text = capsys.readouterr().out
        return code, json.loads(text) if text else None

    return called


def result(returned: Any, **outs: Any) -> tuple[int, Any]:
    return 0, {"return": returned, "outs": outs}


def test_echo(cdl: Path, call: Call) -> None:
    with serving(cdl, "--echo") as address:
        assert call(address, "go", v=1, id=-2) == result(0, id=-2, o=0)
        assert call(address, "fill", n=3) == result(0, v=[0, 0, 0])
        points = [{"x": 0, "y": 0.0}, {"x": 0, "y": 0.0}]
        assert call(address, "points", n=1) == result(0, v=points)
        assert call(address, "octets", max=9, n=2) == result(0, v=[0, 0], n=2)
        assert call(address, "text", n=5) == result(0, s="")
        assert call(address, "plain", s="abc") == result(0)
        assert call(address, "stop") == result(None)
        closed = {"return": ERCD(E_RPC, E_BOVR), "outs": None}
        assert call(address, "fill", n=30000) == (3, closed)
        assert call(address, "fill", n=1) == result(0, v=[0])


def test_check_compares_the_signature_of_a_device(
    cdl: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def check(file: Path, address: str) -> tuple[int, Any]:
        code = run(["rpc", "check", address, "--cdl", str(file), "sMove"])
        text = capsys.readouterr().out
        return code, json.loads(text) if text else None

    other = tmp_path / "other.cdl"
    other.write_text(CDL.replace("[out] uint8_t *o", "[out] int8_t *o"), "utf-8")
    with serving(cdl) as address:
        code, same = check(cdl, address)
        assert (code, same["signature"]) == (0, "sMove")
        assert same["digest"] == same["peer"]
        code, differs = check(other, address)
        assert code == 1
        assert differs["peer"] == same["digest"] != differs["digest"]
    assert check(cdl, address) == (3, None)


SCRIPT = """
{"function": "go", "args": {"v": 1, "id": 2}, "return": 5, "outs": {"id": 9, "o": 7}}
{"function": "go", "return": -17}
{"function": "go", "return": -18, "outs": {"o": 3}, "delay": 0.001}
{"function": "points", "return": -68}
{"function": "plain", "args": {"s": "a"}, "return": 1}
"""


def test_script(cdl: Path, call: Call, tmp_path: Path) -> None:
    path = tmp_path / "script.jsonl"
    path.write_text(SCRIPT, "utf-8")
    with serving(cdl, "--script", str(path)) as address:
        assert call(address, "go", v=1, id=2) == result(5, id=9, o=7)
        assert call(address, "go", v=1, id=2) == result(-17, id=2, o=0)
        assert call(address, "go", v=8, id=4) == result(-18, id=4, o=3)
        assert call(address, "go", v=8, id=4) == result(-18, id=4, o=3)
        assert call(address, "points", n=0) == (3, {"return": -68, "outs": None})
        assert call(address, "plain", s="a") == result(1)
        assert call(address, "plain", s="b") == (3, None)
        assert call(address, "plain", s="a") == result(1)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{", "line"),
        ("[]", "an object of"),
        ('{"function": "none"}', "no function 'none'"),
        ('{"function": "go", "args": {}}', "'v' is missing"),
        ('{"function": "go", "args": {"v": 1e99, "id": 1}}', "go"),
        ('{"function": "go", "outs": {"x": 1}}', "outs: an object of id, o"),
        ('{"function": "go", "delay": -1}', "delay"),
        ('{"function": "go", "delays": 1}', "an object of"),
    ],
)
def test_lines_that_cannot_be_used(cdl: Path, line: str, message: str) -> None:
    service = service_of(CdlFiles(cdl).units()[0], "sMove", Wire(NETWORK, "tecsgen"))
    with pytest.raises(ScriptError, match=message) as caught:
        MockBoard(service, f"\n{line}\n")
    assert caught.value.line == 2


def test_calls_are_printed(cdl: Path, call: Call) -> None:
    command = [sys.executable, "-m", "rtgen", "rpc", "serve", "--cdl", str(cdl)]
    command += ["--signature", "sMove", "--port", "0", "--verbose"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        address = process.stdout.readline().split()[1]
        call(address, "plain", s="abc")
        printed = {"function": "plain", "args": {"s": "abc"}, "return": 0, "outs": {}}
        assert json.loads(process.stdout.readline()) == printed
        process.terminate()


def test_nobody_listens(cdl: Path, capsys: pytest.CaptureFixture[str]) -> None:
    address = f"127.0.0.1:{free_port()}"
    words = ["rpc", "call", address, "--cdl", str(cdl), "--timeout", "0.1"]
    assert run([*words, "sMove.fill", '{"n": 1}']) == 3
    captured = capsys.readouterr()
    assert json.loads(captured.out)["return"] == ERCD(E_RPC, E_OBJ)
    assert address in captured.err
    assert run([*words, "sMove.plain", '{"s": ""}']) == 3
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["127.0.0.1", "sMove.stop"], "HOST:PORT"),
        (["127.0.0.1:0", "sMove.stop"], "HOST:PORT"),
        (["127.0.0.1:1"], "give HOST:PORT"),
        (["127.0.0.1:1", "sMove.stop", "{}", "{}"], "give HOST:PORT"),
        (["127.0.0.1:1", "sMove.go", "{}"], "'v' is missing"),
        (["--serial", "/dev/no-such", "sMove.halt"], "no function"),
    ],
)
def test_command_lines_that_are_wrong(
    cdl: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert run(["rpc", "call", "--cdl", str(cdl), *words]) == 2
    assert message in capsys.readouterr().err


def test_a_device_that_is_not_there(
    cdl: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--cdl", str(cdl), "--serial", "/dev/no-such"]
    assert run(["rpc", "call", *words, "sMove.stop"]) == 3
    assert "/dev/no-such" in capsys.readouterr().err
    assert run(["rpc", "serve", *words, "--signature", "sMove"]) == 3
    assert "/dev/no-such" in capsys.readouterr().err
