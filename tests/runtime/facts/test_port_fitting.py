"""Which ports can be connected, by what their profiles state."""

from __future__ import annotations

from itertools import product

import pytest

from rtgen.facts.port_fitting import (
    IN_PORT,
    OUT_PORT,
    SERVICE_PORT,
    StatedInterface,
    StatedPort,
    is_same_type,
    obstacle,
)

LONG, DOUBLE = "IDL:RTC/TimedLong:1.0", "IDL:RTC/TimedDouble:1.0"
SAME = [
    (LONG, LONG),
    (LONG, "RTC::TimedLong"),
    (LONG, "TimedLong"),
    (LONG, " TimedLong "),
    ("RTC::TimedLong", "TimedLong"),
    ("", LONG),
    ("Any", LONG),
    ("any", LONG),
    ("", ""),
    ("IDL:TimedLong:1.0", "TimedLong"),
    ("IDL:A/B/C:1.0", "A::B::C"),
    ("IDL:A/B/C:1.0", "C"),
]
OTHER = [
    (LONG, DOUBLE),
    (LONG, "RTC::TimedDouble"),
    (LONG, "TimedDouble"),
    (LONG, "IDL:Other/TimedLong:1.0"),
    (LONG, "Other::TimedLong"),
    (LONG, "IDL:TimedLong:1.0"),
    ("TimedLong", "TimedLongSeq"),
    (LONG, "RTC"),
    (LONG, "IDL:RTC/timedlong:1.0"),
]


@pytest.mark.parametrize(("one", "other"), SAME)
def test_same_types(one: str, other: str) -> None:
    assert is_same_type(one, other)
    assert is_same_type(other, one)


@pytest.mark.parametrize(("one", "other"), OTHER)
def test_other_types(one: str, other: str) -> None:
    assert not is_same_type(one, other)
    assert not is_same_type(other, one)


def service(*interfaces: tuple[str, bool]) -> StatedPort:
    return StatedPort(
        SERVICE_PORT, interfaces=tuple(StatedInterface(*each) for each in interfaces)
    )


FITTING = [
    (StatedPort(OUT_PORT, LONG), StatedPort(IN_PORT, LONG)),
    (StatedPort(OUT_PORT, LONG), StatedPort(IN_PORT, "")),
    (service(("A::B", True)), service(("B", False))),
    (service(("A", False), ("B", True)), service(("C", True), ("B", False))),
]
NOT_FITTING = [
    (
        StatedPort(OUT_PORT, LONG),
        StatedPort(IN_PORT, DOUBLE),
        "they have different types: RTC::TimedLong and RTC::TimedDouble",
    ),
    (
        StatedPort(OUT_PORT, LONG),
        StatedPort(OUT_PORT, LONG),
        "an OutPort is not connected to an OutPort",
    ),
    (
        StatedPort(OUT_PORT, LONG),
        service(("A", True)),
        "an OutPort is not connected to a service port",
    ),
    (
        service(("A", True)),
        service(("A", True)),
        "neither provides an interface that the other requires",
    ),
    (
        service(("A", True)),
        service(("B", False)),
        "neither provides an interface that the other requires",
    ),
    (service(), service(), "neither provides an interface that the other requires"),
]


@pytest.mark.parametrize(("one", "other"), FITTING)
def test_fitting_ports(one: StatedPort, other: StatedPort) -> None:
    assert obstacle(one, other) == obstacle(other, one) == ""


@pytest.mark.parametrize(("one", "other", "why"), NOT_FITTING)
def test_ports_that_do_not_fit(one: StatedPort, other: StatedPort, why: str) -> None:
    assert obstacle(one, other) == why
    assert obstacle(other, one)


def test_it_is_symmetric() -> None:
    ports = [
        *(
            StatedPort(kind, type_)
            for kind, type_ in product((IN_PORT, OUT_PORT), (LONG, DOUBLE, "", "Any"))
        ),
        *(service(("A", provided)) for provided in (False, True)),
    ]
    for one, other in product(ports, ports):
        assert bool(obstacle(one, other)) is bool(obstacle(other, one))
