"""COB-IDs that are predefined, restricted, and in force."""

from __future__ import annotations

import pytest

from rtgen.facts.canopen import EXTENDED, INVALID, NO_RTR, SDO_REQUEST, SDO_RESPONSE
from rtgen.facts.cob_ids import (
    COB_ID_EMERGENCY,
    COB_ID_SYNC,
    COB_ID_TIME,
    configurable,
    in_force,
    restricted,
    service_of,
)

NODE = 5


def test_restricted_identifiers() -> None:
    found = [i for i in range(0x800) if restricted(i)]
    for free in (0x080, 0x081, 0x100, 0x181, 0x57F, 0x580, 0x600, 0x680, 0x6DF, 0x700):
        assert free not in found
    for taken in (0, 0x7F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x6FF):
        assert taken in found
    for taken in (0x001, 0x701, 0x77F, 0x780, 0x7FF):
        assert taken in found


def test_predefined_connection_set() -> None:
    for number in range(4):
        for index, base in ((0x1400, 0x200), (0x1800, 0x180)):
            cob_id = in_force((index + number, 1), None, NODE)
            assert cob_id == base + 0x100 * number + NODE
    assert in_force((0x1200, 1), None, NODE) == SDO_REQUEST + NODE
    assert in_force((0x1200, 2), None, NODE) == SDO_RESPONSE + NODE
    assert in_force(COB_ID_SYNC, None, NODE) == 0x80
    assert in_force(COB_ID_TIME, None, NODE) == 0x100
    assert in_force(COB_ID_EMERGENCY, None, NODE) == 0x80 + NODE
    for number in ((0x1404, 1), (0x1804, 1), (0x1201, 1), (0x1280, 2), (0x1028, 3)):
        assert in_force(number, None, NODE) == INVALID


@pytest.mark.parametrize("index", [0x1000, 0x1016, 0x1600, 0x1A00, 0x2000, 0x6040])
def test_other_objects_are_no_cob_ids(index: int) -> None:
    assert service_of((index, 1)) is None
    assert in_force((index, 1), None, NODE) is None
    assert in_force((index, 1), 0, NODE) == 0


@pytest.mark.parametrize(
    ("number", "stated", "wanted"),
    [
        (COB_ID_SYNC, 0, 0x80),
        (COB_ID_SYNC, NO_RTR, NO_RTR | 0x80),
        (COB_ID_SYNC, 0x90, 0x90),
        (COB_ID_SYNC, NO_RTR | 0x105, 0x105),
        (COB_ID_TIME, INVALID, INVALID | 0x100),
        (COB_ID_TIME, INVALID | NO_RTR | 0x7F0, 0x7F0),
        (COB_ID_EMERGENCY, 0, 0x85),
        (COB_ID_EMERGENCY, 0x80, 0x85),
        (COB_ID_EMERGENCY, 0xA0, 0xA0),
        (COB_ID_EMERGENCY, 0x10, INVALID | 0x10),
        (COB_ID_EMERGENCY, INVALID, INVALID),
        (COB_ID_EMERGENCY, EXTENDED | 0x10, EXTENDED | 0x10),
        ((0x1800, 1), 0, 0x185),
        ((0x1800, 1), NO_RTR, NO_RTR | 0x185),
        ((0x1800, 1), 0x180, 0x185),
        ((0x1400, 1), 0x200, 0x205),
        ((0x1401, 1), 0x200, 0x200),
        ((0x1400, 1), 0x605, INVALID | 0x605),
        ((0x1400, 1), 0x1234, INVALID | 0x1234),
        ((0x1404, 1), 0, INVALID),
        ((0x1200, 1), 0x605, 0x605),
    ],
)
def test_cob_ids_in_force(number: tuple[int, int], stated: int, wanted: int) -> None:
    assert in_force(number, stated, NODE) == wanted


def test_a_function_code_that_was_chosen_for_a_node_is_itself() -> None:
    assert in_force((0x1400, 1), 0x200, NODE, chosen=True) == 0x200
    assert in_force((0x1400, 1), 0, NODE, chosen=True) == 0x205


@pytest.mark.sampled(5)
@pytest.mark.parametrize("node_id", [1, 64, 127])
@pytest.mark.parametrize(
    "number",
    [COB_ID_SYNC, COB_ID_TIME, COB_ID_EMERGENCY, (0x1201, 1), (0x1400, 1), (0x1984, 1)],
)
def test_no_service_exists_on_a_restricted_identifier(
    number: tuple[int, int], node_id: int
) -> None:
    service = service_of(number)
    assert service is not None
    for identifier in range(0x1000):
        for flags in (0, NO_RTR, INVALID, INVALID | NO_RTR):
            found = in_force(number, flags | identifier, node_id)
            assert found is not None
            assert configurable(found) or not service.exists(found)
