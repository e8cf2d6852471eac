"""Generated clients and servers on odd input, compared with C peers of real tecsgen.

Two differences are deliberate: a scalar that is split over segments is accepted, and a text longer
than its `string(e)` is refused.
"""

from __future__ import annotations

import importlib
import inspect
import json
import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rtgen.cli import run
from rtgen.runtime.opaque_rpc import TcpChannel, TcpServer, make_tdr

GOLDEN = Path(__file__).parents[1] / "golden" / "tecs"
ODD = json.loads((GOLDEN / "opaque_rpc_odd_input.json").read_text("utf-8"))
TRACES = json.loads((GOLDEN / "opaque_rpc_traces.json").read_text("utf-8"))
GOOD_REPLY = "561e000000006d5e"
LONG = 20.0
PAUSE = 0.02
DIFFERENT: dict[str, dict[str, Any]] = {
    "int32 split in two segments": {"reply": GOOD_REPLY, "connection": "open"},
    "function id split": {"reply": GOOD_REPLY, "connection": "open"},
    "string(16) with length 200": {"reply": "", "connection": "closed"},
    "return value split in two segments": {"client_return": 0, "client_outs": {}},
}
"""Inputs that rtgen accepts and C peers refuse, or the other way round."""

PROJECT = """[sources]
paths = ["odd.cdl"]
[output]
package = "odd_input"
skeletons = "src"
"""


def _cdl() -> str:
    used = {case["signature"] for case in ODD["server"] + ODD["client"]}
    text = TRACES["allocator_cdl"]
    for number, name in enumerate(sorted(used)):
        text += f"{TRACES['signatures'][name]}\n"
        text += f"celltype tB{number} {{ entry {name} eB; }};\n"
        text += f"[active] celltype tC{number} {{ call {name} cB; }};\n"
        text += f"cell tB{number} B{number} {{}};\n"
        text += f'cell tC{number} C{number} {{ [through(RTCPlugin,"")] cB = B{number}.eB; }};\n'
    return text


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Import the generated package, under a name of its own."""
    folder = tmp_path_factory.mktemp("odd")
    (folder / "rtgen.toml").write_text(PROJECT, "utf-8")
    (folder / "odd.cdl").write_text(_cdl(), "utf-8")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert run(["generate", "-q"]) == 0
    finally:
        os.chdir(before)
    sys.path.insert(0, str(folder / "generated"))
    yield "odd_input.tecs.odd"
    sys.path.remove(str(folder / "generated"))


def parts(package: str, signature: str) -> SimpleNamespace:
    """Return the generated classes of a signature."""
    name = signature.removeprefix("s")
    server = importlib.import_module(f"{package}.{name.lower()}_server")
    marshaller = importlib.import_module(f"{package}.{name.lower()}_marshaller")
    codec = importlib.import_module(f"{package}.{name.lower()}_codec")
    return SimpleNamespace(
        target=getattr(server, f"{name}Target"),
        unmarshaller=getattr(server, f"{name}Unmarshaller"),
        proxy=getattr(marshaller, f"{name}Proxy"),
        codec=getattr(codec, f"{name}Codec"),
    )


ANSWERS: dict[str, Callable[..., Any]] = {
    "func1": lambda indata: 0,
    "func2": lambda: (0, 0x54),
    "flip": lambda v: (v, not v),
    "count": len,
    "put": lambda s: (0, len(s)),
}
"""The answers of the recorded server."""


def board(target: type, calls: list[str], answers: dict[str, Any]) -> Any:
    """Return a target with given answers; other functions answer 0 and 1 (`isnull`)."""

    def method(name: str) -> Callable[..., Any]:
        def called(_: object, *arguments: Any) -> Any:
            calls.append(name)
            return answers.get(name, lambda *_: (0, 1))(*arguments)

        return called

    names = [name for name, _ in inspect.getmembers(target, inspect.isfunction)]
    return type("Board", (target,), {name: method(name) for name in names})()


def names_of(cases: list[dict[str, Any]]) -> list[str]:
    return [case["name"] for case in cases]


@pytest.mark.parametrize("case", ODD["server"], ids=names_of(ODD["server"]))
def test_server(package: str, case: dict[str, Any]) -> None:
    case = {**case, **DIFFERENT.get(case["name"], {})}
    generated = parts(package, case["signature"])
    calls: list[str] = []
    target = board(generated.target, calls, ANSWERS)
    reply = bytes.fromhex(case["reply"])
    with TcpServer(generated.unmarshaller(target), timeout=LONG) as server:
        with socket.create_connection(server.address, timeout=LONG) as client:
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            for number, segment in enumerate(case["segments"]):
                time.sleep(PAUSE if number else 0)
                client.sendall(bytes.fromhex(segment))
            if case["connection"] == "open":
                assert _received(client, len(reply)) == reply
                client.setblocking(False)
                with pytest.raises(BlockingIOError):
                    client.recv(1)
            else:
                assert _received(client, 1000) == reply == b""
        executed = len(calls)
        assert executed == case["reply"].count("561e")
        if case["signature"] == "sServer":
            proxy = generated.proxy(TcpChannel(*server.address, timeout=LONG))
            assert proxy.func1(1) == 0
            proxy.channel.close()
            assert len(calls) == executed + 1


def _received(client: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        try:
            piece = client.recv(size - len(data))
        except ConnectionResetError:
            break
        if not piece:
            break
        data += piece
    return data


@pytest.mark.parametrize("case", ODD["client"], ids=names_of(ODD["client"]))
def test_client(package: str, case: dict[str, Any]) -> None:
    case = {**case, **DIFFERENT.get(case["name"], {})}
    generated = parts(package, case["signature"])
    recorded = next(
        trace["request"]
        for trace in TRACES["cases"]
        if trace["tdr"] == "tNBOTDR" and trace["function"] == case["function"]
    )
    with socket.create_server(("127.0.0.1", 0)) as listener:
        channel = TcpChannel(*listener.getsockname(), timeout=LONG)
        proxy = generated.proxy(channel, generated.codec(make_tdr("network")))
        requests: list[bytes] = []

        def serve() -> None:
            for _ in range(2):
                peer, _ = listener.accept()
                with peer:
                    peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    requests.append(_received(peer, len(recorded) // 2))
                    for segment in case["server_sends"]:
                        peer.sendall(bytes.fromhex(segment))
                        time.sleep(PAUSE)

        thread = threading.Thread(target=serve)
        thread.start()
        for _ in range(2):
            outcome = getattr(proxy, case["function"])(*case["args"].values())
            returned, *outs = outcome if isinstance(outcome, tuple) else (outcome,)
            assert returned == case["client_return"]
            if case["client_outs"] is not None:
                assert outs == list(case["client_outs"].values())
            elif case["function"] == "func3":
                assert outs == [case["args"]["iodata"]]
            else:
                assert outs == []
            channel.close()
        thread.join()
        assert len(requests) == 2
        assert requests[0] == requests[1]
