"""Generated servers and clients with a hand-written peer and the recorded values.

The messages are compared with the recordings of C peers, in both directions.
"""

from __future__ import annotations

import copy
import importlib
import json
import os
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import opaque_rpc_peer as peer
import pytest

from rtgen.cli import run
from rtgen.runtime.opaque_rpc import TcpChannel, TcpServer, make_tdr

GOLDEN = Path(__file__).parents[1] / "golden" / "tecs"
TRACES = json.loads((GOLDEN / "opaque_rpc_traces.json").read_text("utf-8"))
HOST = "127.0.0.1"
LONG = 20.0
STRUCTS = {"tagPoint": {"x", "y"}, "tagBlob": {"kind", "data", "len"}}
STRUCTS["tagRect"] = {"a", "b", "tag", "on"}
OCTETS = {("part", "v"), ("grow", "v")}
"""Arrays of uint8_t: bytes in Python. So are `tag` and `data` of the structs."""
ASKED = {("opt", "q"), ("two", "a"), ("two", "c")}
"""Nullable outs: a bool in the request."""
WIDE = {"w", "back"}
PROJECT = '[sources]\npaths = ["peer.cdl"]\n[output]\npackage = "by_hand"\n'


def _with_floats(case: dict[str, Any]) -> dict[str, Any]:
    """Return the case with infinities, which JSON has as texts."""
    if case["function"] not in ("f32", "f64"):
        return case
    args, outs = ({n: float(v) for n, v in case[p].items()} for p in ("args", "outs"))
    return {**case, "args": args, "outs": outs, "return": float(case["return"])}


CASES = [_with_floats(c) for c in TRACES["cases"] if c["signature"] in peer.FUNCTIONS]


def _cdl() -> str:
    text = ""
    for n, name in enumerate(sorted({case["signature"] for case in CASES})):
        text += f"{TRACES['signatures'][name]}\n"
        text += f"celltype tB{n} {{ entry {name} eB; }};\n"
        text += f"[active] celltype tC{n} {{ call {name} cB; }};\n"
        text += f"cell tB{n} B{n} {{}};\n"
        text += f'cell tC{n} C{n} {{ [through(RTCPlugin,"")] cB = B{n}.eB; }};\n'
    return text


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Import the generated package, under a name of its own."""
    folder = tmp_path_factory.mktemp("peer")
    (folder / "rtgen.toml").write_text(PROJECT, "utf-8")
    (folder / "peer.cdl").write_text(_cdl(), "utf-8")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert run(["generate", "-q"]) == 0
    finally:
        os.chdir(before)
    sys.path.insert(0, str(folder / "generated"))
    yield "by_hand.tecs.peer"
    sys.path.remove(str(folder / "generated"))


class Generated:
    """The generated classes for a recorded call, and its values in Python."""

    def __init__(self, package: str, case: dict[str, Any]) -> None:
        name = case["signature"].removeprefix("s")
        self._case = case
        self._types = importlib.import_module(f"{package}._types")
        self._server = self._module(package, name, "server")
        self._name = name
        codec = getattr(self._module(package, name, "codec"), f"{name}Codec")
        self.codec = codec(make_tdr("little" if native(case) else "network"))
        self.proxy = getattr(self._module(package, name, "marshaller"), f"{name}Proxy")

    def _module(self, package: str, name: str, kind: str) -> ModuleType:
        return importlib.import_module(f"{package}.{name.lower()}_{kind}")

    def unmarshaller(self, called: list[Any]) -> Any:
        """Serve a target that answers as recorded."""
        base = getattr(self._server, f"{self._name}Target")

        def method(name: str) -> Callable[..., Any]:
            def answer(_: object, *arguments: object) -> object:
                called.append((name, list(arguments)))
                return self.result()

            return answer

        target = type(
            "Board", (base,), {n: method(n) for n in base.__abstractmethods__}
        )
        return getattr(self._server, f"{self._name}Unmarshaller")(target(), self.codec)

    def arguments(self, args: dict[str, Any]) -> list[Any]:
        """Return the recorded arguments as generated code has them."""
        function = self._case["function"]
        return [
            value is not None if (function, n) in ASKED else self.value(n, value)
            for n, value in args.items()
        ]

    def result(self) -> Any:
        """Return the results; omitted outs are inouts unchanged, and zero."""
        case = self._case
        left_out = {"o": case["args"].get("o"), "p": 0}
        outs = left_out if case["outs"] is None else case["outs"]
        values = [self.value(n, value) for n, value in outs.items()]
        if case["return"] is not None:
            values.insert(0, self.value("return", case["return"]))
        return tuple(values) if len(values) > 1 else values[0] if values else None

    def value(self, name: str, value: Any) -> Any:
        """Return a recorded value as generated code has it."""
        if name in WIDE:
            return [ord(unit) for unit in value]
        if isinstance(value, dict):
            tag = next(t for t, members in STRUCTS.items() if members == set(value))
            members = {n: self.value(n, v) for n, v in value.items()}
            return getattr(self._types, tag)(**members)
        if (self._case["function"], name) in OCTETS or name in ("tag", "data"):
            return bytes(value)
        if isinstance(value, list):
            return [self.value("", each) for each in value]
        return value


def native(case: dict[str, Any]) -> bool:
    return bool(case["tdr"] == "tTDR")


def names_of(cases: list[dict[str, Any]]) -> list[str]:
    return [case["id"] for case in cases]


@pytest.mark.sampled(44)
@pytest.mark.parametrize("case", CASES, ids=names_of(CASES))
def test_a_client_by_hand(package: str, case: dict[str, Any]) -> None:
    generated = Generated(package, case)
    called: list[Any] = []
    with (
        TcpServer(generated.unmarshaller(called), timeout=LONG) as server,
        socket.create_connection(server.address, timeout=LONG) as link,
    ):
        request, reply, outs = peer.call(
            link,
            case["signature"],
            case["func_id"],
            copy.deepcopy(case["args"]),
            native(case),
        )
        link.shutdown(socket.SHUT_WR)
        assert link.recv(1) == b""
    assert request.hex() == case["request"]
    assert reply.hex() == case["response"]
    assert outs == recorded(case)
    assert called == [(case["function"], generated.arguments(sent(case)))]


@pytest.mark.sampled(44)
@pytest.mark.parametrize("case", CASES, ids=names_of(CASES))
def test_a_server_by_hand(package: str, case: dict[str, Any]) -> None:
    generated = Generated(package, case)
    served: list[Any] = []
    with socket.create_server((HOST, 0)) as listener:
        listener.settimeout(LONG)

        def serve() -> None:
            link, _ = listener.accept()
            with link:
                link.settimeout(LONG)
                served.extend(
                    peer.serve(link, case["signature"], recorded(case), native(case))
                )

        thread = threading.Thread(target=serve)
        thread.start()
        channel = TcpChannel(*listener.getsockname(), timeout=LONG)
        proxy = generated.proxy(channel, generated.codec)
        result = getattr(proxy, case["function"])(*generated.arguments(case["args"]))
        thread.join()
        channel.close()
    request, reply, number, args = served
    assert request.hex() == case["request"]
    assert reply.hex() == case["response"]
    assert number == case["func_id"]
    assert args == sent(case)
    assert result == (0 if case["function"] == "fire2" else generated.result())


def recorded(case: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a reply, `return` among it."""
    values = copy.deepcopy(case["outs"]) or {}
    return values if case["return"] is None else {**values, "return": case["return"]}


def sent(case: dict[str, Any]) -> dict[str, Any]:
    """Return the content of a request: counted arrays up to their count."""
    args = copy.deepcopy(case["args"])
    if case["function"] == "part":
        args["v"] = args["v"][: args["n"]]
    if case["function"] == "grow":
        args["v"] = args["v"][: args["len"]]
    return dict(args)


def test_every_recorded_function_is_written_by_hand() -> None:
    """Except two signatures: one needs allocators at its cells, IDL cannot express the other."""
    missing = {c["signature"] for c in TRACES["cases"]} - set(peer.FUNCTIONS)
    assert missing == {"sXfer", "sExtra"}
    assert {(c["signature"], c["func_id"]) for c in CASES} == {
        (name, number) for name, found in peer.FUNCTIONS.items() for number in found
    }
