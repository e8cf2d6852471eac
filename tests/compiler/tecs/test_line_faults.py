"""Calls of 20 random functions while the line is cut at every byte and the board is killed.

A call ends with its result or an error in time, nothing is executed twice, and the line works
again. `make fuzz` makes 20,000 calls and more.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from random import Random
from time import monotonic
from typing import Any

import pytest
from line_faults import TIMEOUT, Board, Line, Script
from random_signatures import plain
from seeds import budget, seed

from rtgen.compiler.layouts.tdr_messages import is_error_code
from rtgen.runtime.opaque_rpc import E_RPC, MERCD, RpcError, TcpChannel
from rtgen.tools.rpc.codecs import Function

CALLS = budget(700)
PATIENCE = 5 * TIMEOUT
"""Time-out of a call on a busy machine [s]; only a hanging one exceeds it."""


class Caller:
    """Makes the calls of a script over the line, and records their outcomes."""

    def __init__(self, seed: int, folder: Path) -> None:
        self.script = Script(seed)
        self.log = folder / "executed"
        self.number = 0
        self.answered: list[str] = []
        self.failed: list[str] = []
        self.board = Board(seed, self.log)
        self.line = Line(self.board.port)
        self.channel = TcpChannel("127.0.0.1", self.line.port, TIMEOUT)
        codec = self.script.service.codec
        self.proxy = self.script.generated.proxy(self.channel, codec)

    def call(self, function: Function) -> bool:
        """Make the next call; return whether it has its result."""
        number, self.number = self.number, self.number + 1
        call = self.script.call(number, function)
        arguments = self.script.arguments(function, call)
        method = getattr(self.proxy, self.script.generated.methods[function.name])
        begun = monotonic()
        layout = function.layout
        try:
            result = method(*arguments)
        except RpcError:
            succeeded = False
        else:
            wanted = self.script.result(function, call)
            code: Any = result[0] if isinstance(result, tuple) else result
            if function.oneway:
                succeeded = code in (None, 0)
            elif plain(result) == plain(wanted):
                succeeded = True
            else:
                # A call that failed, or a board's own E_RPC, which omits the outs.
                assert is_error_code(layout.function.returns), (function.name, number)
                assert MERCD(code) == E_RPC, (function.name, number, result, wanted)
                succeeded = code == call.returned
        assert monotonic() - begun < PATIENCE
        ended = self.answered if succeeded else self.failed
        ended.append(f"{number} {function.name}")
        return succeeded

    def restart(self) -> None:
        """Kill the board and start another one."""
        self.board.kill()
        self.board = Board(self.script.seed, self.log)
        self.line.board = self.board.port

    def executed(self) -> list[str]:
        """Return the calls that a board has executed, in that order."""
        return self.log.read_text().splitlines() if self.log.exists() else []

    def close(self) -> None:
        self.channel.close()
        self.line.close()
        self.board.kill()

    def check(self) -> None:
        """Check that nothing was executed twice or without a call, and every answered call was.

        The board serves one connection after the other, so an answered call ends everything sent
        before it: a request that arrived completely before its connection was cut is executed late.
        """
        self.channel.reset()
        assert any(self.call(f) for f in self.script.functions if not f.oneway)
        executed = self.executed()
        assert len(set(executed)) == len(executed)
        assert set(executed) <= {*self.answered, *self.failed}
        functions = self.script.service.functions
        answered = [a for a in self.answered if not functions[a.split()[1]].oneway]
        assert set(answered) <= set(executed)
        assert executed == sorted(executed, key=lambda text: int(text.split()[0]))


@pytest.fixture
def caller(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> Iterator[Caller]:
    caplog.set_level(logging.CRITICAL)
    made = Caller(seed(), tmp_path)
    yield made
    made.close()


def test_the_line_is_cut_at_every_byte(caller: Caller) -> None:
    whole = budget(1) > 1
    for function in caller.script.functions:
        # A oneway call could be written into the connection that was cut last.
        caller.channel.reset()
        assert caller.call(function)
        before = list(caller.line.carried)
        assert caller.call(function)
        sizes = [a - b for a, b in zip(caller.line.carried, before, strict=True)]
        for direction in (0, 1):
            step = 1 if whole else max(1, sizes[direction] // 3)
            for after in range(0, sizes[direction], step):
                caller.line.cut(direction, after)
                caller.call(function)
                caller.line.mend()
    assert caller.failed
    caller.check()


@pytest.mark.nightly
def test_random_calls_with_faults(caller: Caller) -> None:
    random = Random(seed())
    for count in range(CALLS):
        function = random.choice(caller.script.functions)
        fault = random.random()
        if fault < 0.1:
            caller.line.cut(random.randint(0, 1), random.randint(0, 60))
        if count % max(CALLS // 4, 1) == CALLS // 8:
            caller.restart()
            caller.call(function)  # over the connection to the board that was killed
        caller.call(function)
        caller.line.mend()
    for function in caller.script.functions:
        caller.call(function)
        assert caller.call(function) or function.oneway
    # Those drawn may all have been after the octets of their calls.
    for function in caller.script.functions:
        caller.line.cut(1, 0)
        assert not caller.call(function) or function.oneway
        caller.line.mend()
    assert caller.failed
    caller.check()
