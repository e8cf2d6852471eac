"""Ports whose calls are in C behave as those in Python."""

from __future__ import annotations

import inspect
import random
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
import seeds
import speed
from runtime_samples import Actor, TimedLong, TwinOfTimedLong, joined, long

from rtgen.runtime import OutPort
from rtgen.runtime.ports import data_ports

FULL = "dataport.buffer.write.full_policy"
LENGTH = "dataport.buffer.length"


@pytest.fixture
def choose(monkeypatch: pytest.MonkeyPatch) -> Callable[[Any], None]:
    """Choose the module in C, or None, for connections from now on."""
    return partial(speed.choose_for_ports, monkeypatch)


@pytest.fixture
def module(choose: Callable[[Any], None]) -> Any:
    """The calls are in C from now on."""
    built = speed.module()
    choose(built)
    return built


def outcome(action: Callable[[], Any]) -> object:
    """Return the result, or the error with its text."""
    try:
        result = action()
    except Exception as error:
        return type(error), str(error)
    return result.data if isinstance(result, TimedLong) else result


def trace(properties: dict[str, str], seed: int, readers: int) -> list[object]:
    """Return what random calls of two connected ports return, and what was counted."""
    system, out, port = joined(properties)
    write: Any = out.write
    for number in range(readers - 1):
        system.add(Actor(f"other{number}", inputs=("in",)))
        system.connect(("writer", "out"), (f"other{number}", "in"))
    chance = random.Random(seed)
    found: list[object] = []
    for number in range(60):
        match chance.randrange(8):
            case 0 | 1:
                found.append(outcome(partial(write, long(number))))
            case 2:
                found.append(
                    outcome(partial(lambda n: write(long(n), move=True), number))
                )
            case 3:
                found.append(outcome(lambda: write(TwinOfTimedLong(data=7))))
            case 4:
                found.append(outcome(lambda: write("text")))
            case 5:
                found.append(outcome(port.is_new))
            case 6:
                found.append(outcome(port.read_newest))
            case _:
                found.append(outcome(port.read))
        last = port.last
        found.append((port.unread, port.lost, out.unsent, last and last.data))
    return found


@pytest.mark.parametrize("policy", ["overwrite", "do_nothing", "block"])
@pytest.mark.parametrize("readers", [1, 2])
def test_calls_in_c_and_in_python_agree(
    policy: str, readers: int, choose: Callable[[Any], None]
) -> None:
    module = speed.module()
    properties = {FULL: policy, LENGTH: "3"}
    traces = []
    for chosen in (None, module):
        choose(chosen)
        traces.append([trace(properties, case, readers) for case in seeds.cases(50)])
        assert isinstance(vars(OutPort)["write"], module.Method) is (chosen is module)
    assert traces[0] == traces[1]


def test_calls_in_c_refuse_what_functions_refuse(module: Any) -> None:
    ports: Any = joined()
    _, out, port = ports
    for call in (
        lambda: out.write(),
        lambda: out.write(long(1), True),
        lambda: out.write(long(1), moved=True),
        lambda: port.read(1),
        lambda: port.is_new(new=1),
        lambda: OutPort.write(port, long(1)),
    ):
        with pytest.raises((TypeError, AttributeError)):
            call()
    assert not port.is_new()


def test_a_sample_is_given_away_in_c_if_one_variable_has_it(module: Any) -> None:
    _, out, port = joined()
    sample = long(1)
    write = out.write
    write(sample, move=True)
    assert port.read() is sample
    kept = [sample]
    write(sample, move=True)
    assert port.read() is not sample
    assert kept == [sample]
    write(sample, move=False)
    assert port.read() is not sample


def test_calls_in_c_look_like_functions(module: Any) -> None:
    joined()
    call = vars(OutPort)["write"]
    assert isinstance(call, module.Method)
    assert "snapshot of the sample" in (inspect.getdoc(call) or "")
    assert list(inspect.signature(call).parameters) == ["self", "value", "move"]
    assert (call.__name__, call.__qualname__) == ("write", "OutPort.write")
    assert call.__module__ == data_ports.__name__
