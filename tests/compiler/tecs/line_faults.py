"""A board of 20 random functions in a process of its own, and a line to it that can be cut.

    python line_faults.py SEED LOG        the board; prints its port

The first parameter of each function is the number of the call; all values follow from the seed and
the number, so the board knows the right arguments and results. It writes the number to LOG before
it answers.
"""

from __future__ import annotations

import os
import selectors
import socket
import subprocess
import sys
import threading
from pathlib import Path
from random import Random
from typing import Any

from msgspec.structs import replace
from random_signatures import Call, _parameter, plain, sample, scalar
from services import Generated

from rtgen.compiler.model.tecs import TecsDirection
from rtgen.facts.tdr import Scalar
from rtgen.runtime.opaque_rpc import NETWORK, TcpServer
from rtgen.tools.rpc.codecs import Function, Service

FUNCTIONS = 20
NUMBER = "call_number"
LIMIT = 1 << 20
TIMEOUT = 10.0


class Script:
    """The calls of a seed by their numbers."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self._found = found = sample(Random(seed), FUNCTIONS)
        number = _parameter(NUMBER, scalar(Scalar.UINT32), TecsDirection.IN)
        functions = tuple(
            replace(f, parameters=(number, *f.parameters))
            for f in found.signature.functions
        )
        signature = replace(found.signature, functions=functions)
        others = tuple(d for d in found.unit.declarations if d != found.signature)
        unit = replace(found.unit, declarations=(*others, signature))
        self.service = Service(unit, signature, NETWORK)
        self.functions = list(self.service.functions.values())
        self.generated = Generated(self.service)

    def call(self, number: int, function: Function) -> Call:
        """Return the values of a call."""
        random = Random(f"{self.seed} {number} {function.name}")
        declared = function.layout.function
        call = self._found.call(random, declared, self.service.types)
        call.args[NUMBER] = number
        return call

    def arguments(self, function: Function, call: Call) -> tuple[Any, ...]:
        """Return the arguments of the caller."""
        return tuple(call.args[item.name] for item in function.layout.arguments)

    def result(self, function: Function, call: Call) -> Any:
        """Return the result of the board."""
        layout = function.layout
        values = [] if layout.is_void else [call.returned]
        values += [call.outs[item.name] for item in layout.outs]
        return None if not values else values[0] if len(values) == 1 else tuple(values)


def serve(seed: int, log: str) -> None:
    """Serve forever."""
    script = Script(seed)
    file = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)

    def method(function: Function) -> Any:
        def execute(_: object, *arguments: Any) -> Any:
            call = script.call(arguments[0], function)
            same = plain(script.arguments(function, call)) == plain(arguments)
            mark = arguments[0] if same else "altered"
            os.write(file, f"{mark} {function.name}\n".encode())
            return script.result(function, call)

        return execute

    names = script.generated.methods
    methods = {names[f.name]: method(f) for f in script.functions}
    target = type("Target", (script.generated.target,), methods)()
    unmarshaller = script.generated.unmarshaller(target, script.service.codec)
    server = TcpServer(unmarshaller, timeout=TIMEOUT, allocator_size=LIMIT)
    print(server.address[1], flush=True)
    server.serve_forever()


class Board:
    """The process of a board."""

    def __init__(self, seed: int, log: Path) -> None:
        command = [sys.executable, __file__, str(seed), str(log)]
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        assert self._process.stdout is not None
        self.port = int(self._process.stdout.readline())

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


class Line:
    """Carries bytes between a caller and the board.

    `cut` lets it break after that many further bytes of a direction (0: the caller's).
    """

    def __init__(self, port: int) -> None:
        self.board = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self.carried = [0, 0]
        self._left: list[int | None] = [None, None]
        self._closed = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def cut(self, direction: int, after: int) -> None:
        self._left[direction] = after

    def mend(self) -> None:
        self._left = [None, None]

    def close(self) -> None:
        self._closed = True
        self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._listener.close()

    def _run(self) -> None:
        while not self._closed:
            try:
                caller = self._listener.accept()[0]
            except OSError:
                return
            with caller:
                try:
                    board = socket.create_connection(("127.0.0.1", self.board))
                except OSError:
                    continue
                with board:
                    self._carry(caller, board)

    def _carry(self, caller: socket.socket, board: socket.socket) -> None:
        ends = (caller, board)
        for end in ends:
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        with selectors.DefaultSelector() as selector:
            for direction, end in enumerate(ends):
                selector.register(end, selectors.EVENT_READ, direction)
            while not self._closed:
                for key, _ in selector.select(0.1):
                    if not self._pass(ends, key.data):
                        return

    def _pass(self, ends: tuple[socket.socket, socket.socket], direction: int) -> bool:
        """Forward the available bytes; return whether the line goes on."""
        try:
            data = ends[direction].recv(65536)
            # `mend` replaces the list, also while it is in use here.
            cuts = self._left
            left = cuts[direction]
            self.carried[direction] += len(data)
            part = data if left is None else data[:left]
            ends[1 - direction].sendall(part)
        except OSError:
            return False
        if left is not None:
            cuts[direction] = left - len(part)
            return bool(data) and len(part) == len(data) and left > len(part)
        return bool(data)


if __name__ == "__main__":
    serve(int(sys.argv[1]), sys.argv[2])
