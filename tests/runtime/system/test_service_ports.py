"""Providers, consumers, and calls between them; hand-written interfaces like generated ones."""

from __future__ import annotations

import threading
from abc import abstractmethod
from typing import Any, ClassVar

import numpy
import pytest
from runtime_samples import MS, SECOND, Actor, TimedList, activated

from rtgen.runtime import (
    BadOperation,
    ConnectorPropertyError,
    DuplicateConnectionError,
    DuplicatePortError,
    ObjectNotExist,
    PolarityError,
    PortTypeError,
    RealClock,
    Servant,
    ServiceConnector,
    Skeleton,
    Stub,
    System,
    UnknownException,
    UnknownPortError,
)
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor
from rtgen.runtime.marshalling.numeric import NumericArray
from rtgen.runtime.services.servants import operation


class TooMuchError(Exception):
    """The user exception of Adder."""


class Adder(Servant):
    _descriptor_: ClassVar[InterfaceDescriptor] = InterfaceDescriptor(
        "IDL:Adder:1.0", "Adder", ("void add(in TimedList what)", "TimedList all()")
    )

    @abstractmethod
    @operation(raises=(TooMuchError,))
    def add(self, what: TimedList) -> None: ...

    @abstractmethod
    def all(self) -> tuple[TimedList, list[TimedList]]: ...


class AdderStub(Adder, Stub):
    """Calls an Adder through an invoker."""


class AdderSkeleton(Skeleton, interface=Adder):
    """Calls an Adder by operation name."""


class BetterAdder(Adder):
    """An interface that derives from Adder, as a class."""

    _descriptor_ = InterfaceDescriptor(
        "IDL:BetterAdder:1.0", "BetterAdder", (), (Adder._descriptor_,)
    )


class AdderOfAnotherPackage(Servant):
    """The same IDL type as another class."""

    _descriptor_ = Adder._descriptor_
    _stub_ = AdderStub
    _skeleton_ = AdderSkeleton


class BetterOfAnotherPackage(AdderOfAnotherPackage):
    """An interface that derives from Adder by repository id only."""

    _descriptor_ = BetterAdder._descriptor_


class Shouter(Servant):
    _descriptor_ = InterfaceDescriptor("IDL:Shouter:1.0", "Shouter", ("void shout()",))
    _stub_ = Stub
    _skeleton_ = Skeleton


class Sum(Adder):
    """A servant."""

    def __init__(self) -> None:
        self.kept: list[TimedList] = []

    def add(self, what: TimedList) -> None:
        if what.data == [0]:
            raise TooMuchError("too much")
        if what.data == [1]:
            raise KeyError("surprise")
        self.kept.append(what)

    def all(self) -> tuple[TimedList, list[TimedList]]:
        return self.kept[0], self.kept


def provider(
    name: str,
    interface: type[Any] = Adder,
    instance: str = "adder",
    *,
    port: str = "sums",
) -> tuple[Actor, Sum]:
    actor, servant = Actor(name), Sum()
    actor.add_provider(port, instance, interface).set_servant(servant)
    return actor, servant


def consumer(
    name: str, interface: type[Any] = Adder, instance: str = "adder"
) -> tuple[Actor, Any]:
    actor = Actor(name)
    return actor, actor.add_consumer("calls", instance, interface)


def system_of(*components: Actor) -> System:
    system = activated(System(), *components)
    system.run(until_ns=MS)
    return system


def connected() -> tuple[System, Sum, Any]:
    giver, servant = provider("giver")
    taker, end = consumer("taker")
    system = system_of(giver, taker)
    system.connect(("giver", "sums"), ("taker", "calls"), name="c")
    return system, servant, end


def test_a_call_reaches_the_servant() -> None:
    _, servant, end = connected()
    assert end.connected
    end.object.add(TimedList([3]))
    assert servant.kept == [TimedList([3])]
    assert isinstance(end.object, Adder)
    assert end.object is end.object


def test_a_consumer_is_called_without_its_object() -> None:
    with pytest.raises(ObjectNotExist, match="not connected"):
        Actor("Alone").add_consumer("use", "use", Adder).add(TimedList())
    consumer = Actor("Other").add_consumer("use", "use", Adder)
    assert consumer.all.__name__ == "all"
    with pytest.raises(AttributeError):
        consumer.nothing  # noqa: B018


def test_arguments_and_results_are_copies() -> None:
    _, servant, end = connected()
    argument = TimedList([3])
    end.object.add(argument)
    argument.data.append(4)
    assert servant.kept == [TimedList([3])]
    first, everything = end.object.all()
    first.data.append(5)
    everything.append(TimedList())
    everything[0].data.append(6)
    assert servant.kept == [TimedList([3])]


@pytest.mark.parametrize(
    "numbers", [NumericArray("d", [1.0, 2.0]), numpy.array([1.0, 2.0])]
)
def test_numbers_are_copies_in_each_form(numbers: Any) -> None:
    _, servant, end = connected()
    servant.kept = [numbers]
    first, everything = end.object.all()
    assert type(first) is type(everything[0]) is type(numbers)
    first[1] = everything[0][0] = 3.0
    assert list(first) == [1.0, 3.0]
    assert list(numbers) == [1.0, 2.0]


def test_exceptions_of_the_idl_pass_and_others_become_unknown() -> None:
    _, _, end = connected()
    with pytest.raises(TooMuchError, match="too much"):
        end.object.add(TimedList([0]))
    with pytest.raises(UnknownException, match="surprise") as caught:
        end.object.add(TimedList([1]))
    assert isinstance(caught.value.__cause__, KeyError)
    with pytest.raises(BadOperation):
        end._call("subtract", ())


def test_only_an_active_provider_answers() -> None:
    system, _, end = connected()
    system.deactivate("giver")
    system.run(until_ns=2 * MS)
    with pytest.raises(
        ObjectNotExist, match=r"giver.sums:adder is not active, so 'add' cannot"
    ):
        end.object.add(TimedList())
    system.activate("giver")
    system.run(until_ns=3 * MS)
    end.object.add(TimedList())
    assert end.connected


def test_without_connection_and_without_servant() -> None:
    giver, _ = provider("giver")
    bare = Actor("bare")
    bare.add_provider("sums", "adder", Adder)
    taker, end = consumer("taker")
    system = system_of(giver, bare, taker)
    with pytest.raises(ObjectNotExist, match=r"taker.calls:adder is not connected"):
        end.object.all()
    system.connect(("taker", "calls"), ("bare", "sums"), name="c")
    with pytest.raises(ObjectNotExist, match=r"bare.sums:adder has no servant"):
        end.object.all()
    system.disconnect("c")
    assert not end.connected
    system.connect(("giver", "sums"), ("taker", "calls"), name="c")
    end.object.add(TimedList())


def test_one_provider_serves_many_consumers() -> None:
    giver, servant = provider("giver")
    (one, first), (two, second) = consumer("one"), consumer("two")
    system = system_of(giver, one, two)
    system.connect(("giver", "sums"), ("one", "calls"))
    system.connect(("giver", "sums"), ("two", "calls"))
    first.object.add(TimedList([7]))
    second.object.add(TimedList([8]))
    assert servant.kept == [TimedList([7]), TimedList([8])]


def test_a_consumer_has_one_provider_at_a_time() -> None:
    system, _, _ = connected()
    other, _ = provider("other")
    activated(system, other)
    with pytest.raises(
        DuplicateConnectionError, match=r"taker.calls:adder is connected already"
    ):
        system.connect(("other", "sums"), ("taker", "calls"))


@pytest.mark.parametrize(
    "interface", [BetterAdder, AdderOfAnotherPackage, BetterOfAnotherPackage]
)
def test_interfaces_that_fit(interface: type[Any]) -> None:
    giver, servant = provider("giver", interface)
    taker, end = consumer("taker")
    system = system_of(giver, taker)
    system.connect(("giver", "sums"), ("taker", "calls"))
    end.object.add(TimedList([7]))
    assert servant.kept == [TimedList([7])]


def test_the_only_one_of_a_type_is_found_whatever_its_name() -> None:
    giver, servant = provider("giver", instance="sum")
    giver.add_provider("sums", "shout", Shouter)
    taker, end = consumer("taker", instance="adder")
    system = system_of(giver, taker)
    connector = system.connect(("giver", "sums"), ("taker", "calls"))
    assert isinstance(connector, ServiceConnector)
    assert [(str(c), str(p)) for c, p in connector.pairs] == [
        ("taker.calls:adder", "giver.sums:sum")
    ]
    end.object.add(TimedList([7]))
    assert len(servant.kept) == 1


def two_of_each() -> tuple[System, Any, Any, Sum, Sum]:
    giver, left = provider("giver", instance="left")
    right = Sum()
    giver.add_provider("sums", "right", Adder).set_servant(right)
    taker, first = consumer("taker", instance="right")
    second = taker.add_consumer("calls", "other", Adder)
    return system_of(giver, taker), first, second, left, right


def test_names_decide_where_there_are_several() -> None:
    system, first, second, left, right = two_of_each()
    system.connect(("giver", "sums"), ("taker", "calls"))
    first.object.add(TimedList([7]))
    assert (left.kept, right.kept) == ([], [TimedList([7])])
    assert not second.connected


def test_a_strict_connection_leaves_no_consumer_alone() -> None:
    system, first, _, _, _ = two_of_each()
    with pytest.raises(PortTypeError, match=r"no provider for taker.calls:other"):
        system.connect(
            ("giver", "sums"),
            ("taker", "calls"),
            {"port.connection.strictness": "strict"},
        )
    assert not first.connected


def test_names_can_be_joined_by_hand() -> None:
    system, first, second, left, right = two_of_each()
    by_hand = {
        "taker.port.calls.required.Adder.other": "giver.port.sums.provided.Adder.left"
    }
    system.connect(("giver", "sums"), ("taker", "calls"), by_hand)
    first.object.add(TimedList([7]))
    second.object.add(TimedList([8]))
    assert (left.kept, right.kept) == ([TimedList([8])], [TimedList([7])])


@pytest.mark.parametrize(
    ("properties", "reason"),
    [
        (
            {"taker.port.calls.required.Adder.other": "nobody"},
            "'nobody' is not a provider",
        ),
        ({"taker.port.calls.required.Adder.ghost": "x"}, "names no consumer"),
        ({"port.connection.strictness": "lax"}, "strict or best_effort"),
        (
            {"dataport.buffer.length": "8"},
            "unknown connector property 'dataport.buffer.length'",
        ),
    ],
)
def test_bad_properties(properties: dict[str, str], reason: str) -> None:
    system, *_ = two_of_each()
    with pytest.raises(ConnectorPropertyError, match=reason):
        system.connect(("giver", "sums"), ("taker", "calls"), properties)


def test_a_wrong_type_shows_both_interfaces() -> None:
    giver, _ = provider("giver", Shouter)
    taker, _ = consumer("taker")
    system = system_of(giver, taker)
    with pytest.raises(PortTypeError) as caught:
        system.connect(("giver", "sums"), ("taker", "calls"))
    message = str(caught.value)
    assert "taker.calls:adder and giver.sums:adder have different interfaces" in message
    assert "IDL:Adder:1.0" in message
    assert "IDL:Shouter:1.0" in message
    by_hand = {
        "taker.port.calls.required.Adder.adder": "giver.port.sums.provided.Shouter.adder"
    }
    with pytest.raises(PortTypeError, match="have different interfaces"):
        system.connect(("giver", "sums"), ("taker", "calls"), by_hand)


def test_too_many_candidates() -> None:
    giver, _ = provider("giver", instance="left")
    giver.add_provider("sums", "right", Adder)
    taker, _ = consumer("taker")
    system = system_of(giver, taker)
    with pytest.raises(PortTypeError, match="no instance names agree"):
        system.connect(("giver", "sums"), ("taker", "calls"))


def test_polarity() -> None:
    (one, _), (two, _) = provider("one"), provider("two")
    (three, _), (four, _) = consumer("three"), consumer("four")
    three.add_in_port("data", TimedList)
    system = system_of(one, two, three, four)
    with pytest.raises(PolarityError, match="both only provide"):
        system.connect(("one", "sums"), ("two", "sums"))
    with pytest.raises(PolarityError, match="both only require"):
        system.connect(("three", "calls"), ("four", "calls"))
    with pytest.raises(PolarityError, match="they are service port and InPort"):
        system.connect(("one", "sums"), ("three", "data"))
    with pytest.raises(UnknownPortError, match="one has no port 'adder'; known: sums"):
        system.connect(("one", "adder"), ("three", "calls"))


def test_one_port_may_hold_both_polarities() -> None:
    system = System()
    pairs = []
    for name in ("one", "two"):
        actor, servant = provider(name, port="both")
        pairs.append((actor.add_consumer("both", "adder", Adder), servant))
        activated(system, actor)
    system.run(until_ns=MS)
    connector = system.connect(("one", "both"), ("two", "both"))
    assert isinstance(connector, ServiceConnector)
    assert len(connector.pairs) == 2
    pairs[0][0].object.add(TimedList([7]))
    assert (pairs[0][1].kept, pairs[1][1].kept) == ([], [TimedList([7])])
    system.remove("two")
    assert not pairs[0][0].connected


def test_an_interface_is_added_once() -> None:
    actor, _ = provider("giver")
    with pytest.raises(
        DuplicatePortError, match=r"giver has a port giver.sums:adder already"
    ):
        actor.add_provider("sums", "adder", Adder)


def test_a_failed_call_in_a_callback_is_a_failure_like_any_other() -> None:
    taker, end = consumer("taker")
    taker.execute = lambda: end.object.add(TimedList())
    system = system_of(taker)
    reason = system.statistics("taker").reason
    place, _, what = reason.partition(": ")
    assert place.startswith("on_execute (")
    assert what.startswith("ObjectNotExist: taker.calls")


def test_calls_between_threads_in_real_time() -> None:
    giver, servant = provider("giver")
    taker, end = consumer("taker")
    called = threading.Event()

    def call() -> None:
        if not called.is_set() and giver.is_active:
            end.object.add(TimedList([7]))
            called.set()

    taker.execute = call
    with activated(System(RealClock()), giver, taker) as system:
        system.connect(("giver", "sums"), ("taker", "calls"))
        assert system.run(10 * SECOND, lambda _: called.is_set())
        assert servant.kept == [TimedList([7])]
