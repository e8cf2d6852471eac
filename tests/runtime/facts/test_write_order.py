"""The order in which objects are written: what may only change while another one is off."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from rtgen.facts.cob_ids import Number, service_of
from rtgen.facts.write_order import How, obstacles, steps

OFF = 1 << 31
ON = 1 << 30
FLAGS = OFF | ON

Values = Mapping[Number, int]
Written = list[tuple[Number, int]]


class Node:
    """Values before and after; objects in `fixed` cannot be written."""

    def __init__(
        self, before: Values, after: Values, fixed: frozenset[Number] = frozenset()
    ) -> None:
        self._before = before
        self._after = {**before, **after}
        self._fixed = fixed

    def before(self, number: Number) -> int | None:
        return self._before.get(number)

    def after(self, number: Number) -> int | None:
        return self._after.get(number)

    def states(self, number: Number) -> bool:
        return number in self._before

    def configured(self, number: Number) -> int | None:
        return None

    def moves(self, number: Number) -> bool:
        before, after = self.before(number) or 0, self.after(number) or 0
        return before & ~FLAGS != after & ~FLAGS

    def writable(self, number: Number) -> bool:
        return number in self._after and number not in self._fixed

    def value(self, number: Number, how: How) -> int:
        if how is How.ZERO:
            return 0
        before, after = self.before(number), self.after(number)
        assert after is not None
        if how is How.VALUE:
            return after
        service = service_of(number)
        assert service is not None
        if how is How.OFF:
            return service.switched_off(after)
        assert before is not None
        return service.switched_off(before)


def written(before: Values, after: Values, fixed: tuple[Number, ...] = ()) -> Written:
    node = Node(before, after, frozenset(fixed))
    return [(s.number, node.value(s.number, s.how)) for s in steps(list(after), node)]


EMCY, TIME, SYNC = (0x1014, 0), (0x1012, 0), (0x1005, 0)
PERIOD, COUNTER = (0x1006, 0), (0x1019, 0)


@pytest.mark.parametrize(
    ("before", "after", "values"),
    [
        (0x85, 0xA0, [OFF | 0x85, OFF | 0xA0, 0xA0]),
        (0x85, OFF | 0x85, [OFF | 0x85]),
        (0x85, OFF | 0xA0, [OFF | 0x85, OFF | 0xA0]),
        (OFF | 0x85, 0x85, [0x85]),
        (OFF | 0x85, 0xA0, [OFF | 0xA0, 0xA0]),
        (0x85, 0x85, [0x85]),
    ],
)
def test_emergencies_are_off_while_their_identifier_changes(
    before: int, after: int, values: list[int]
) -> None:
    assert written({EMCY: before}, {EMCY: after}) == [(EMCY, v) for v in values]


def test_the_inhibit_time_is_written_while_emergencies_are_off() -> None:
    before = {EMCY: 0x85, (0x1015, 0): 0}
    assert written(before, {(0x1015, 0): 100, EMCY: 0xA0}) == [
        (EMCY, OFF | 0x85),
        (EMCY, OFF | 0xA0),
        ((0x1015, 0), 100),
        (EMCY, 0xA0),
    ]


def test_time_is_neither_consumed_nor_produced_while_its_identifier_changes() -> None:
    assert written({TIME: OFF | 0x100}, {TIME: OFF | 0x120}) == [
        (TIME, 0x100),
        (TIME, 0x120),
        (TIME, OFF | 0x120),
    ]
    assert written({TIME: 0x100}, {TIME: 0x120}) == [(TIME, 0x120)]


def test_sync_is_not_produced_while_its_identifier_changes() -> None:
    assert written({SYNC: ON | 0x80}, {SYNC: ON | 0x90}) == [
        (SYNC, 0x80),
        (SYNC, 0x90),
        (SYNC, ON | 0x90),
    ]
    assert written({SYNC: 0x80}, {SYNC: 0x90}) == [(SYNC, 0x90)]


@pytest.mark.parametrize(
    ("before", "after", "wanted"),
    [
        ({PERIOD: 0}, {COUNTER: 10, PERIOD: 500}, [(COUNTER, 10), (PERIOD, 500)]),
        ({PERIOD: 9}, {COUNTER: 10}, [(PERIOD, 0), (COUNTER, 10), (PERIOD, 9)]),
        (
            {PERIOD: 9},
            {COUNTER: 10, PERIOD: 8},
            [(PERIOD, 0), (COUNTER, 10), (PERIOD, 8)],
        ),
        ({PERIOD: 9}, {COUNTER: 10, PERIOD: 0}, [(PERIOD, 0), (COUNTER, 10)]),
        ({PERIOD: 9}, {PERIOD: 8}, [(PERIOD, 8)]),
        ({}, {COUNTER: 10}, [(COUNTER, 10)]),
    ],
)
def test_the_sync_counter_is_written_while_the_period_is_0(
    before: Values, after: Values, wanted: Written
) -> None:
    assert written({COUNTER: 0, **before}, after) == wanted


def entry(node_id: int, time: int = 100) -> int:
    return node_id << 16 | time


@pytest.mark.parametrize(
    ("before", "after", "wanted"),
    [
        ([(7, 1), (8, 1)], {1: (8, 1), 2: (7, 1)}, [1, 2, 1, 2]),
        ([(7, 1), (8, 1)], {1: (9, 1), 2: (7, 1)}, [1, 1, 2]),
        ([(7, 1), (8, 1), (9, 1)], {1: (8, 1), 2: (9, 1), 3: (7, 1)}, [1, 2, 3] * 2),
        ([(7, 1), (0, 0)], {1: (7, 5)}, [1]),
        ([(7, 0), (8, 1)], {2: (7, 1)}, [2]),
    ],
)
def test_consumers_that_change_places_are_off_in_between(
    before: list[tuple[int, int]],
    after: dict[int, tuple[int, int]],
    wanted: list[int],
) -> None:
    known = {(0x1016, n): entry(*each) for n, each in enumerate(before, 1)}
    values = {(0x1016, n): entry(*each) for n, each in after.items()}
    found = written(known, values)
    assert [number[1] for number, _ in found] == wanted
    assert [v for _, v in found][-len(values) :] == list(values.values())
    assert not any(v for _, v in found[: -len(values)])


@pytest.mark.parametrize("index", [0x1201, 0x127F, 0x1280, 0x12FF])
def test_an_sdo_is_off_while_it_changes(index: int) -> None:
    request, response, node = (index, 1), (index, 2), (index, 3)
    before = {request: 0x680, response: 0x510, node: 4}
    assert written(before, {request: 0x690}) == [
        (request, OFF | 0x680),
        (request, OFF | 0x690),
        (request, 0x690),
    ]
    assert written(before, {node: 6}) == [
        (request, OFF | 0x680),
        (response, OFF | 0x510),
        (node, 6),
        (request, 0x680),
        (response, 0x510),
    ]
    before = {request: OFF, response: OFF, node: 0}
    assert written(before, {request: 0x680, response: 0x510, node: 4}) == [
        (request, OFF | 0x680),
        (response, OFF | 0x510),
        (node, 4),
        (request, 0x680),
        (response, 0x510),
    ]


@pytest.mark.parametrize("index", [0x1400, 0x1800, 0x19FF])
def test_a_pdo_is_off_while_it_changes(index: int) -> None:
    cob_id, kind, mapping = (index, 1), (index, 2), index + 0x200
    before = {
        cob_id: 0x185,
        kind: 255,
        (mapping, 0): 1,
        (mapping, 1): 0x60000108,
        (mapping, 2): 0,
    }
    after = {
        cob_id: 0x190,
        kind: 1,
        (mapping, 0): 2,
        (mapping, 2): 0x60000208,
    }
    assert written(before, after) == [
        (cob_id, OFF | 0x185),
        (cob_id, OFF | 0x190),
        (kind, 1),
        ((mapping, 0), 0),
        ((mapping, 1), 0x60000108),
        ((mapping, 2), 0x60000208),
        ((mapping, 0), 2),
        (cob_id, 0x190),
    ]
    assert written(before, {kind: 1}) == [
        (cob_id, OFF | 0x185),
        (kind, 1),
        (cob_id, 0x185),
    ]


def test_a_multiplexed_pdo_gets_its_entries_and_its_number() -> None:
    cob_id, count, first = (0x1800, 1), (0x1A00, 0), (0x1A00, 1)
    before = {cob_id: OFF | 0x185, count: 0, first: 0}
    assert written(before, {count: 0xFE, first: 0x01600001}) == [
        (cob_id, OFF | 0x185),
        (count, 0),
        (first, 0x01600001),
        (count, 0xFE),
    ]


def test_objects_come_in_groups() -> None:
    order = [
        (0x1014, 0), (0x1017, 0), (0x1016, 1), (0x1201, 1), (0x1F80, 0), (0x1800, 2),
        (0x1400, 2), (0x2000, 0), (0x6040, 0), (0x1020, 1), (0x1010, 1), (0x1011, 1),
    ]  # fmt: skip
    after = dict.fromkeys(reversed(order), 1)
    found = list(dict.fromkeys(number for number, _ in written(after, after)))
    assert [n for n in found if n in order] == order


def test_changes_that_no_order_makes_possible() -> None:
    cob_id, count, first = (0x1800, 1), (0x1A00, 0), (0x1A00, 1)
    before = {cob_id: 0x185, count: 1, first: 0x60000108, PERIOD: 9, COUNTER: 0}
    after = {first: 0x60000208, (0x1800, 3): 10, (0x1800, 5): 10, COUNTER: 2}
    node = Node(before, after, frozenset((cob_id, PERIOD)))
    assert {o.number for o in obstacles(list(after), node)} == {
        first,
        (0x1800, 3),
        COUNTER,
    }
    assert list(obstacles(list(after), Node(before, after))) == []
    node = Node(before, after, frozenset((count,)))
    assert {o.number for o in obstacles(list(after), node)} == {first}
