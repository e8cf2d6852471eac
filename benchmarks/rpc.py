"""Calls of an empty function over loopback: OpaqueRPC compared with TCP, omniORBpy and gRPC.

    python benchmarks/rpc.py

Each server is a process of its own, and all use a time-out; the raw one sends the same bytes.
Batches of 100 calls of both alternate; the ratio is the median of those of 200 such pairs. Then the
procedure of the RTM-TECS paper, 100 calls, mean and spread; and a server that writes each scalar by
itself, as C servers do.

All processes are bound to one processor if the system can do that: otherwise some pairs wait for an
idle processor to wake up, ten times as long as the call takes.
"""

from __future__ import annotations

import importlib
import os
import shutil
import socket
import statistics
import struct
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tables import Arguments, Results, Table

PAIRS, WARM_UP, CALLS = 200, 20, 100
SLOW_PAIRS = 5
LIMITS = {"raw": 1.6, "omniORBpy": 1.0, "grpcio": 0.2}
"""Maximum ratios to the peers."""
TIMEOUT = 1.0
HOST = "127.0.0.1"
REQUEST = bytes.fromhex("672a00015a3c")
REPLY = bytes.fromhex("561e000000006d5e")
SCALARS = (b"\x56", b"\x1e", b"\0\0\0\0", b"\x6d\x5e")
"""The reply as C servers write it."""

CDL = """
signature sEmpty { ER nothing( void ); };
celltype tBoard { entry sEmpty eEmpty; };
[active] celltype tCaller { call sEmpty cEmpty; };
cell tBoard Board {};
cell tCaller Caller { [through(RTCPlugin,"")] cEmpty = Board.eEmpty; };
"""
PROJECT = '[sources]\npaths = ["empty.cdl"]\n[output]\npackage = "bench"\n'
IDL = "interface Empty { long nothing(); };"

Call = Callable[[], object]


# Programs of the servers; each prints its own address to standard output.


def announced(address: object) -> None:
    print(address, flush=True)


def armed(connection: socket.socket) -> socket.socket:
    """Return a connection with rtgen's time-out."""
    limit = struct.pack("@ll", int(TIMEOUT), 0)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, limit)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, limit)
    return connection


def serve_raw(folder: Path) -> None:
    with socket.create_server((HOST, 0)) as listener:
        announced(listener.getsockname()[1])
        connection = armed(listener.accept()[0])
        receive, send = connection.recv, connection.send
        while True:
            try:
                if not receive(len(REQUEST)):
                    return
            except BlockingIOError:
                continue
            send(REPLY)


def serve_scalars(folder: Path) -> None:
    with socket.create_server((HOST, 0)) as listener:
        announced(listener.getsockname()[1])
        while True:
            with listener.accept()[0] as connection:
                while connection.recv(len(REQUEST)):
                    for scalar in SCALARS:
                        connection.send(scalar)


def serve_rtgen(folder: Path) -> None:
    from rtgen.runtime.opaque_rpc import TcpServer

    module = generated(folder, "empty.empty_server")

    class Board(module.EmptyTarget):  # type: ignore[misc,name-defined]
        def nothing(self) -> int:
            return 0

    server = TcpServer(module.EmptyUnmarshaller(Board()), HOST, 0, TIMEOUT)
    announced(server.address[1])
    server.serve_forever()


def serve_omniorb(folder: Path) -> None:
    orb = omniorb(folder)
    poa_module = importlib.import_module("_GlobalIDL__POA")

    class Servant(poa_module.Empty):  # type: ignore[misc,name-defined]
        def nothing(self) -> int:
            return 0

    servant = Servant()
    poa = orb.resolve_initial_references("RootPOA")
    poa._get_the_POAManager().activate()
    announced(orb.object_to_string(servant._this()))
    orb.run()


def serve_grpc(folder: Path) -> None:
    import concurrent.futures

    import grpc

    def nothing(request: bytes, context: object) -> bytes:
        return REPLY

    handler = grpc.unary_unary_rpc_method_handler(nothing)
    pool = concurrent.futures.ThreadPoolExecutor(1)
    server = grpc.server(pool)
    server.add_generic_rpc_handlers(
        (grpc.method_handlers_generic_handler("Empty", {"nothing": handler}),)
    )
    announced(server.add_insecure_port(f"{HOST}:0"))
    server.start()
    server.wait_for_termination()


SERVERS = {
    "raw": serve_raw,
    "scalars": serve_scalars,
    "rtgen": serve_rtgen,
    "omniORBpy": serve_omniorb,
    "grpcio": serve_grpc,
}


# Clients.


def raw_call(port: str) -> Call:
    connection = armed(socket.create_connection((HOST, int(port))))
    receive, send = connection.recv, connection.send

    def call() -> None:
        send(REQUEST)
        receive(len(REPLY))

    return call


def ordinary_call(port: str) -> Call:
    """Return a client that does not handle delayed acknowledgements."""
    connection = armed(socket.create_connection((HOST, int(port))))

    def call() -> None:
        connection.send(REQUEST)
        data = b""
        while len(data) < len(REPLY):
            data += connection.recv(len(REPLY) - len(data))

    return call


def rtgen_call(port: str, folder: Path) -> Call:
    from rtgen.runtime.opaque_rpc import TcpChannel

    module = generated(folder, "empty.empty_marshaller")
    proxy = module.EmptyProxy(TcpChannel(HOST, int(port), TIMEOUT))
    assert proxy.nothing() == 0
    return proxy.nothing  # type: ignore[no-any-return]


def omniorb_call(reference: str, folder: Path) -> Call:
    orb = omniorb(folder)
    module = importlib.import_module("_GlobalIDL")
    empty = orb.string_to_object(reference)._narrow(module.Empty)
    return empty.nothing  # type: ignore[no-any-return]


def grpc_call(port: str) -> Call:
    import grpc

    channel = grpc.insecure_channel(f"{HOST}:{port}")
    method = channel.unary_unary("/Empty/nothing")
    return lambda: method(REQUEST, timeout=TIMEOUT)


def generated(folder: Path, module: str) -> Any:
    """Return a module that rtgen generated from the CDL text."""
    sys.path.insert(0, str(folder / "generated"))
    return importlib.import_module(f"bench.tecs.{module}")


def omniorb(folder: Path) -> Any:
    sys.path.insert(0, str(folder))
    orb_module = importlib.import_module("omniORB.CORBA")
    arguments = ["bench", "-ORBclientCallTimeOutPeriod", str(int(TIMEOUT * 1000))]
    return orb_module.ORB_init(arguments, orb_module.ORB_ID)


def prepare(folder: Path) -> None:
    """Generate the code of all."""
    (folder / "empty.cdl").write_text(CDL, encoding="utf-8")
    (folder / "rtgen.toml").write_text(PROJECT, encoding="utf-8")
    (folder / "empty.idl").write_text(IDL, encoding="utf-8")
    command = [sys.executable, "-m", "rtgen", "generate", "-q"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    scripts = sysconfig.get_path("scripts")
    omniidl = shutil.which("omniidl", path=f"{scripts}{os.pathsep}{os.environ['PATH']}")
    if omniidl is not None:
        subprocess.run([omniidl, "-bpython", "empty.idl"], cwd=folder, check=True)


@contextmanager
def server(name: str, folder: Path) -> Iterator[str]:
    """Start a server in a process of its own; yield its address."""
    command = [sys.executable, __file__, name, str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.kill()


def batch(call: Call, calls: int = CALLS) -> float:
    """Return microseconds of each of `calls` calls."""
    start = time.perf_counter_ns()
    for _ in range(calls):
        call()
    return (time.perf_counter_ns() - start) / calls / 1000


def compared(peer: Call, ours: Call, pairs: int) -> tuple[list[float], list[float]]:
    """Return the times of both, from alternating batches."""
    for _ in range(min(WARM_UP, pairs)):
        batch(peer)
        batch(ours)
    times = [(batch(peer), batch(ours)) for _ in range(pairs)]
    return [a for a, _ in times], [b for _, b in times]


COLUMNS = [
    *((f"{title} [µs]", ".2f") for title in ("mean", "median", "99 %", "spread")),
    ("ratio", ".3f"),
    ("at most", "g"),
]
"""Columns of a table of calls: ratio to the peer, and its limit."""


def add(
    table: Table,
    name: str,
    times: list[float],
    ratio: float | None = None,
    limit: float | None = None,
) -> None:
    """Add the times of a call to a table."""
    ordered = sorted(times)
    high = ordered[min(len(ordered) - 1, int(len(ordered) * 0.99))]
    spread = statistics.stdev(times) if len(times) > 1 else None
    figures = statistics.mean(times), statistics.median(times), high, spread
    table.add(name, *figures, ratio, limit)


def ratio(peer: list[float], ours: list[float]) -> float:
    """Return the median of the ratios of pairs."""
    return statistics.median(b / a for a, b in zip(peer, ours, strict=True))


def main() -> int:
    """Print the figures; return 1 if a limit is exceeded."""
    chosen = Arguments(__doc__, rounds=PAIRS).parse_args()
    makers: dict[str, Callable[[str, Path], Call]] = {
        "raw": lambda address, _: raw_call(address),
        "omniORBpy": omniorb_call,
        "grpcio": lambda address, _: grpc_call(address),
    }
    too_slow = False
    if sys.platform == "linux":
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    with Results(__file__, chosen) as results, tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        prepare(folder)
        table = results.table("calls", "an empty call", *COLUMNS)
        with server("rtgen", folder) as address:
            ours = rtgen_call(address, folder)
            for peer, maker in makers.items():
                try:
                    with server(peer, folder) as peer_address:
                        call = maker(peer_address, folder)
                        call()
                        theirs, mine = compared(call, ours, chosen.rounds)
                except ImportError as error:
                    print(f"{peer}: left out, {error}")
                    continue
                value = ratio(theirs, mine)
                add(table, peer, theirs)
                add(table, f"rtgen beside {peer}", mine, value, LIMITS[peer])
                too_slow |= value > LIMITS[peer]
            one_by_one = [batch(ours, 1) for _ in range(CALLS)]
            add(table, "100 calls one by one", one_by_one)
        scalars(table, folder, chosen.rounds)
    return int(too_slow and not chosen.smallest)


def scalars(table: Table, folder: Path, pairs: int) -> None:
    """Add the calls of a server that writes each scalar separately, with Nagle's algorithm on."""
    with server("scalars", folder) as address, server("raw", folder) as raw:
        ours = rtgen_call(address, folder)
        theirs, mine = compared(raw_call(raw), ours, pairs)
        add(table, "scalar by scalar, rtgen beside raw", mine, ratio(theirs, mine))
    with server("scalars", folder) as address:
        ordinary = ordinary_call(address)
        times = [batch(ordinary, 10) for _ in range(SLOW_PAIRS)]
        add(table, "scalar by scalar, an ordinary client", times)


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] in SERVERS:
        SERVERS[sys.argv[1]](Path(sys.argv[2]))
    else:
        sys.exit(main())
