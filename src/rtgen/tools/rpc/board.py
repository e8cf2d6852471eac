"""A mock board for `rtgen rpc serve`: echoes arguments or answers from a script."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from rtgen.compiler.layouts.tdr import Counted
from rtgen.compiler.typemap.tecs.python import zero
from rtgen.runtime.opaque_rpc import (
    E_PAR,
    ArgumentError,
    Handler,
    Handlers,
    More,
    ProtocolError,
)
from rtgen.runtime.opaque_rpc.digest import DIGEST, digest_handler
from rtgen.tools.kit.json_text import parse_json
from rtgen.tools.rpc.codecs import Function, Service
from rtgen.tools.rpc.signatures import printed
from rtgen.tools.rpc.values import Json, JsonError

_KEYS = {"function", "args", "return", "outs", "delay"}


class ScriptError(ValueError):
    """An invalid line of a script; `line` is its number."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line = line


@dataclass(slots=True)
class _Answer:
    """A line of a script; `request` are the expected octets of a call, None for any."""

    function: str
    request: bytes | None
    returned: Json
    outs: dict[str, Json]
    delay: float
    used: bool = False


class MockBoard:
    """Serves a signature without a target; `print_call` receives each call as a line.

    Raises ScriptError.
    """

    def __init__(
        self,
        service: Service,
        script: str | None = None,
        print_call: Callable[[str], None] | None = None,
    ) -> None:
        self._service = service
        self._answers = None if script is None else _answers(service, script)
        self._print_call = print_call
        self.handlers: Handlers = {
            service.codec.request_head(f.layout.function.id): self._handler(f)
            for f in service.functions.values()
        } | {service.codec.request_head(DIGEST): digest_handler(service.codec)}

    def _handler(self, function: Function) -> Handler:
        def handle(more: More) -> bytes | None:
            arguments = function.read_request(more)
            try:
                return answer(arguments)
            except (ArgumentError, JsonError) as error:
                raise ProtocolError(E_PAR, str(error)) from error

        def answer(arguments: tuple[object, ...]) -> bytes | None:
            returned, outs = self._result(function, arguments)
            if self._print_call is not None:
                call_json = {
                    "function": function.name,
                    "args": function.arguments_to_json(arguments),
                }
                self._print_call(
                    printed(call_json | function.result_to_json(returned, outs))
                )
            if function.oneway:
                return None
            return function.encode_reply(function.kept(arguments), returned, outs)

        return handle

    def _result(
        self, function: Function, arguments: tuple[object, ...]
    ) -> tuple[object, tuple[object, ...]]:
        echo = _echo(self._service, function, arguments)
        if self._answers is None:
            return echo
        answer = _chosen(self._answers, function, arguments)
        time.sleep(answer.delay)
        result = function.result_to_json(*echo)
        outs = result["outs"]
        assert isinstance(outs, dict)
        returned = result["return"] if answer.returned is None else answer.returned
        return function.result_from_json(
            {"return": returned, "outs": outs | answer.outs}
        )


def _chosen(
    answers: list[_Answer], function: Function, arguments: tuple[object, ...]
) -> _Answer:
    """Return the first unused line of the script that fits the call. Raises JsonError."""
    request = function.encode_request(arguments)
    fitting = [
        answer
        for answer in answers
        if answer.function == function.name and answer.request in (None, request)
    ]
    if not fitting:
        raise JsonError(f"no line of the script fits {function.name}")
    answer = next((a for a in fitting if not a.used), fitting[-1])
    answer.used = True
    return answer


def _answers(service: Service, script: str) -> list[_Answer]:
    answers = []
    for number, line in enumerate(script.splitlines(), 1):
        if line.strip():
            try:
                answers.append(_answer(service, parse_json(line)))
            except (ArgumentError, ValueError, RecursionError) as error:
                raise ScriptError(number, str(error)) from error
    return answers


def _answer(service: Service, line: Json) -> _Answer:
    """Parse a line of the script. Raises ArgumentError, and ValueError with JsonError."""
    if not isinstance(line, dict) or not _KEYS.issuperset(line):
        raise JsonError(f"a line is an object of {', '.join(sorted(_KEYS))}")
    function = service.functions.get(str(line.get("function")))
    if function is None:
        raise JsonError(f"no function {line.get('function')!r}")
    request = None
    if line.get("args") is not None:
        arguments = function.arguments_from_json(line["args"])
        request = function.encode_request(arguments)
    outs = {} if line.get("outs") is None else line["outs"]
    names = {item.name for item in function.layout.outs}
    if not isinstance(outs, dict) or not names.issuperset(outs):
        raise JsonError(f"outs: an object of {', '.join(sorted(names)) or 'nothing'}")
    delay = line.get("delay", 0)
    if not isinstance(delay, int | float) or not 0 <= delay < threading.TIMEOUT_MAX:
        raise JsonError("delay: seconds are needed")
    return _Answer(function.name, request, line.get("return"), outs, delay)


def _echo(
    service: Service, function: Function, arguments: tuple[object, ...]
) -> tuple[object, tuple[object, ...]]:
    """Return the echo: a zero result, unchanged inouts, and zero outs of the requested length."""
    layout = function.layout
    arguments_by_name = dict(
        zip((i.name for i in layout.arguments), arguments, strict=True)
    )
    returned, zeros = function.zeros()
    values = {i.name: z for i, z in zip(layout.outs, zeros, strict=True)} | {
        item.name: arguments_by_name[item.name] for item in layout.outs if item.inward
    }
    values_by_name = arguments_by_name | values
    for item in layout.outs:
        if not item.inward and isinstance(item.node, Counted):
            values[item.name] = _zeros(service, function, item.node, values_by_name)
    return returned, tuple(values[item.name] for item in layout.outs)


def _zeros(
    service: Service,
    function: Function,
    node: Counted,
    values_by_name: dict[str, object],
) -> object:
    count = function.evaluated(node.count, values_by_name)
    if node.is_octets:
        return bytes(count)
    types = dict(vars(service.types))
    return [eval(zero(node.element), types) for _ in range(count)]
