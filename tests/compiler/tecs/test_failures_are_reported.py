"""Messages to the user when a call or a servant fails, without any logging set up."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path

import pytest
from boards import emit, joined, write

from rtgen.cli import run
from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.model.tecs import Signature
from rtgen.runtime.opaque_rpc import (
    E_MAGIC,
    NETWORK,
    ExchangeChannel,
    ProtocolError,
)
from rtgen.tools.rpc.codecs import Service

LAMP = """\
signature sLamp {
  ER dim( [in] uint8_t percent, [out] uint8_t *before );
  int32_t level( void );
};
"""
SERVER = """
import sys
from rtgen.runtime.opaque_rpc import TcpChannel, TcpServer
from robots.tecs.lamp.lamp_marshaller import LampProxy
from robots.tecs.lamp.lamp_server import LampTarget, LampUnmarshaller

class Lamp(LampTarget):
    def dim(self, percent: int) -> tuple[int, int]:
        {body}
    def level(self) -> int:
        return 0

with TcpServer(LampUnmarshaller(Lamp())) as server:
    lamp = LampProxy(TcpChannel(*server.address))
    print(lamp.dim(40))
    print(server.address[1])
"""


@pytest.mark.parametrize(
    "body", ['raise RuntimeError("no bulb")', 'sys.exit("no bulb")']
)
def test_a_servant_that_fails_has_a_traceback(tmp_path: Path, body: str) -> None:
    emission, _ = emit(tmp_path, {"lamp.cdl": joined(LAMP, "sLamp")})
    write(tmp_path, emission.artifacts)
    script = tmp_path / "lamp.py"
    script.write_text(SERVER.format(body=body))
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, cwd=tmp_path
    )
    printed, port = done.stdout.split("\n")[:2]
    assert printed == "(-14660, 0)"
    assert 'lamp.py", line 9, in dim' in done.stderr
    assert "no bulb" in done.stderr
    assert done.stderr.count("Traceback") == 1
    reason = f"sLamp.dim at 127.0.0.1:{port}: 127.0.0.1:{port}: the server closed"
    assert reason in done.stderr


def _lamp() -> Service:
    unit, _ = read_text(LAMP)
    signature = next(d for d in unit.declarations if isinstance(d, Signature))
    return Service(unit, signature, NETWORK)


def test_a_wrong_mark_shows_its_bytes(caplog: pytest.LogCaptureFixture) -> None:
    codec = _lamp().codec
    dim, level = codec.functions["dim"], codec.functions["level"]
    wrong = bytes.fromhex("561f 00000000 07 6d5e")
    with caplog.at_level(logging.WARNING):
        assert dim.call(ExchangeChannel(lambda _: wrong), 40) == (-25924, 0)
    assert "sLamp.dim" in caplog.text
    assert "SOP is 56 1f, expected 56 1e (E_MAGIC)" in caplog.text
    with pytest.raises(ProtocolError, match="EOP is 6d 5f, expected 6d 5e") as caught:
        level.call(ExchangeChannel(lambda _: bytes.fromhex("561e 00000000 6d5f")))
    assert caught.value.sub == E_MAGIC


def test_rpc_finds_imports_by_tecspath(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    library = tmp_path / "library"
    library.mkdir()
    (library / "lamp.cdl").write_text(LAMP)
    (tmp_path / "board.cdl").write_text("import( <lamp.cdl> );\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TECSPATH", str(library))
    assert run(["rpc", "list", "--cdl", "board.cdl"]) == 0
    assert "dim([in] uint8_t percent" in capsys.readouterr().out
