"""Values of samples and calls within a process are checked against their types."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, ClassVar

import pytest
from generated_projects import project

from rtgen.facts.value_checks import FIRST_VALUES
from rtgen.runtime import (
    ERROR_STATE,
    RTC_OK,
    SECOND,
    Component,
    ComponentProfile,
    ReturnCode_t,
    System,
)
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.services.servants import MarshalError

IDL = """
module K {
  enum Colour { RED, GREEN };
  struct Inner { sequence<short> many; };
  struct Sample { short a; string<3> b; float c; Colour hue; Inner part; long list[2]; };
  exception Late { octet minutes; };
  interface Listener { void hear(in octet what); };
  interface Arm {
    attribute octet speed;
    octet move(in octet by, in Sample what) raises (Late);
    void both(in long x, out octet y, inout octet z);
    oneway void go(in octet by);
    void join(in Listener who);
  };
};
"""


@pytest.fixture(scope="module")
def c(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with project(tmp_path_factory.mktemp("checked"), {"c.idl": IDL}, "checked"):
        import checked.k as module

        yield module


class Writer(Component):
    """Writes what a function makes of the number of the tick."""

    profile: ClassVar[ComponentProfile] = ComponentProfile("Writer", rate=1000.0)

    def __init__(self, type_: type[Any], make: Callable[[int], Any]) -> None:
        super().__init__("Writer0")
        self.out = self.add_out_port("out", type_)
        self.make = make
        self.written = 0

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        value = self.make(self.written)
        self.out.write(value)
        self.written += 1
        return RTC_OK


class Reader(Component):
    profile: ClassVar[ComponentProfile] = ComponentProfile("Reader", rate=1000.0)

    def __init__(self, type_: type[Any]) -> None:
        super().__init__("Reader0")
        self.port = self.add_in_port("in", type_)

    def on_execute(self, ec_id: int) -> ReturnCode_t:
        self.port.read()
        return RTC_OK


BAD: dict[str, tuple[Callable[[Any], dict[str, Any]], str]] = {
    "range": (lambda c: {"a": 70000}, "a: 70000 is out of the range of short"),
    "bound": (lambda c: {"b": "abcd"}, "b: 4 octets of UTF-8, and 3 are the most"),
    "kind": (lambda c: {"c": "no"}, "c: a value of float is needed, not 'no'"),
    "enumerator": (lambda c: {"hue": 7}, "hue: 7 is not a member of K::Colour"),
    "nested": (lambda c: {"part": c.Inner([1, 99999])}, "part.many[1]: 99999"),
    "length": (lambda c: {"list": [1]}, "list: "),
    "struct": (lambda c: {"part": None}, "part"),
}


@pytest.mark.parametrize("connected", [True, False])
@pytest.mark.parametrize("name", BAD)
def test_a_wrong_value_stops_the_writer(name: str, connected: bool, c: Any) -> None:
    members, message = BAD[name]
    system = System()
    writer = Writer(c.Sample, lambda _: c.Sample(**members(c)))
    system.add(writer)
    system.add(Reader(c.Sample))
    if connected:
        system.connect(("Writer0", "out"), ("Reader0", "in"))
    system.activate("Writer0")
    system.on_failure = lambda failure: None
    system.run(SECOND // 100)
    assert system.state("Writer0") is ERROR_STATE
    assert f"CdrError: Writer0.out: Sample.{message}" in writer.reason
    assert system.statistics("Writer0").ticks == 1


def late(c: Any, check: str, wrong: Callable[[int], bool], **settings: Any) -> Writer:
    """Return a writer after 1,000 samples, or after the first wrong one that was noticed."""
    system = System(check_values=check)
    writer = Writer(c.Sample, lambda n: c.Sample(a=70000 if wrong(n) else 1))
    system.add(writer)
    system.add(Reader(c.Sample))
    system.connect(("Writer0", "out"), ("Reader0", "in"), settings)
    system.activate("Writer0")
    system.on_failure = lambda failure: None
    system.run(SECOND + 1)
    return writer


def test_always_notices_each_value(c: Any) -> None:
    assert late(c, "always", lambda n: n == 777).written == 777


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {
            "dataport.subscription_type": "periodic",
            "dataport.publisher.push_rate": "100",
        },
    ],
)
def test_first_notices_first_values_and_those_that_stay_wrong(
    c: Any, settings: dict[str, str]
) -> None:
    last = FIRST_VALUES - 1
    assert late(c, "first", lambda n: n == last, **settings).written == last
    found = late(c, "first", lambda n: n >= 500, **settings).written
    assert 500 <= found <= 650
    again = late(c, "first", lambda n: n >= 500, **settings).written
    assert again == found
    assert late(c, "first", lambda n: n == FIRST_VALUES + 5).written > 999


def test_never_notices_nothing(c: Any) -> None:
    assert late(c, "never", lambda n: True).written > 999


def test_samples_that_are_passed_on_are_checked(c: Any) -> None:
    writer, reader = Writer(c.Sample, lambda _: None), Reader(c.Sample)
    system = System()
    system.add(writer)
    system.add(reader)
    system.connect(("Writer0", "out"), ("Reader0", "in"))
    writer.out.write(c.Sample(a=1), move=True)
    with pytest.raises(CdrError, match="70000 is out of the range of short"):
        writer.out.write(c.Sample(a=70000), move=True)


def test_observers_do_not_get_wrong_values(c: Any) -> None:
    seen: list[Any] = []
    system = System()
    system.add(Writer(c.Sample, lambda _: c.Sample(a=70000)))
    system.watch_port("Writer0", "out", seen.append)
    system.on_failure = lambda failure: None
    system.activate("Writer0")
    system.run(SECOND // 100)
    assert not seen


class Caller(Component):
    profile: ClassVar[ComponentProfile] = ComponentProfile("Caller")


class Servants:
    """An arm and what calls it."""

    def __init__(self, c: Any, check: str = "first") -> None:
        outer = self
        self.result: Any = 1
        self.calls = 0
        self.listener: Any = None

        class Listening(c.Listener):
            def hear(self, what: int) -> None: ...

        class Arm(c.Arm):
            speed = 1

            def move(self, by: int, what: Any) -> Any:
                outer.calls += 1
                if isinstance(outer.result, BaseException):
                    raise outer.result
                return outer.result

            def both(self, x: int, z: int) -> Any:
                return outer.result

            def go(self, by: int) -> None:
                outer.calls += 1

            def join(self, who: Any) -> None:
                outer.listener = who

        provider, caller = Caller("Arm0"), Caller("Caller0")
        provider.add_provider("port", "arm", c.Arm).set_servant(Arm())
        self.arm: Any = caller.add_consumer("port", "arm", c.Arm)
        self.listening = Listening()
        self.system = System(check_values=check)
        self.system.add(provider)
        self.system.add(caller)
        self.system.connect(("Caller0", "port"), ("Arm0", "port"))
        self.system.activate("Arm0")
        self.system.run(SECOND // 100)


def test_arguments_are_checked(c: Any) -> None:
    there = Servants(c)
    assert there.arm.move(1, c.Sample()) == 1
    with pytest.raises(CdrError) as error:
        there.arm.move(999, c.Sample())
    assert str(error.value) == (
        "Arm0.port:arm: Arm.move request.by: 999 is out of the range of octet"
    )
    with pytest.raises(CdrError, match=r"move request\.what\.a: 70000 is out of"):
        there.arm.move(1, c.Sample(a=70000))
    with pytest.raises(CdrError, match="a value of octet is needed, not 'x'"):
        there.arm.go("x")
    assert there.calls == 1


def test_results_are_checked(c: Any) -> None:
    there = Servants(c)
    there.result = 300
    with pytest.raises(
        MarshalError, match=r"the result is wrong: .*move reply.*300 is"
    ):
        there.arm.move(1, c.Sample())
    there.result = None
    with pytest.raises(MarshalError, match=r"the result is wrong: .*octet is needed"):
        there.arm.move(1, c.Sample())
    there.result = (1, 2)
    assert there.arm.both(1, 2) == (1, 2)
    there.result = (1, 999)
    with pytest.raises(MarshalError, match=r"the result is wrong: .*999 is out of"):
        there.arm.both(1, 2)


def test_exceptions_are_checked(c: Any) -> None:
    there = Servants(c)
    there.result = c.Late(5)
    with pytest.raises(c.Late):
        there.arm.move(1, c.Sample())
    there.result = c.Late(500)
    with pytest.raises(
        MarshalError, match=r"the exception is wrong: .*minutes: 500 is"
    ):
        there.arm.move(1, c.Sample())


def test_attributes_and_objects(c: Any) -> None:
    there = Servants(c)
    assert there.arm.speed == 1
    with pytest.raises(CdrError, match="999 is out of the range of octet"):
        there.arm.object.speed = 999
    there.arm.join(there.listening)
    assert there.listener is there.listening
    there.arm.join(None)


def test_how_many_calls_are_checked(c: Any) -> None:
    never = Servants(c, "never")
    assert never.arm.move(999, c.Sample()) == 1
    always = Servants(c, "always")
    first = Servants(c, "first")
    for _ in range(FIRST_VALUES):
        always.arm.move(1, c.Sample())
        first.arm.move(1, c.Sample())
    with pytest.raises(CdrError):
        always.arm.move(999, c.Sample())
    assert first.arm.move(999, c.Sample()) == 1
    first.system.run(SECOND)
    with pytest.raises(CdrError):
        first.arm.move(999, c.Sample())
    # Each operation is counted by itself.
    with pytest.raises(CdrError):
        first.arm.go(999)


def test_a_system_refuses_another_word() -> None:
    with pytest.raises(ValueError, match="sometimes"):
        System(check_values="sometimes")
