"""Random types and values: round trips, damaged and truncated octets."""

from __future__ import annotations

import random
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import emitted
import pytest
from random_types import Definitions, Values
from seeds import cases, seed

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.descriptors import (
    NULL,
    AliasDescriptor,
    Descriptor,
    PrimitiveDescriptor,
)
from rtgen.runtime.marshalling.dynamic.values import decoded, encoded

MODULES = 4
TYPES = 40
EXAMPLES = 1000 // MODULES
MAX_CUTS = 12
SMALL = 48


class Types:
    """The classes of a random module, and the possible types of an `any`."""

    def __init__(self, package: Any) -> None:
        found = [t for t in emitted.classes(package) if hasattr(t, "to_cdr")]
        self.classes = {t._descriptor_.repository_id: t for t in found}
        self.described = [t._descriptor_ for t in found]
        basic = ("long", "double", "any", "CORBA::TypeCode", "ValueBase", "Object")
        self.anys: list[Descriptor] = [NULL, *map(PrimitiveDescriptor, basic)]
        self.anys += self.described

    def octets(self, descriptor: Any, value: Any, little_endian: bool) -> bytes:
        """Return the octets of the generated codec, which must equal those of the descriptor's."""
        octets = encoded(descriptor, value, little_endian)
        if isinstance(descriptor, AliasDescriptor):
            class_ = self.classes[descriptor.repository_id]
            assert class_.to_cdr(value, little_endian) == octets
        elif value is not None and value._descriptor_ is descriptor:
            assert value.to_cdr(little_endian) == octets
        return octets


@pytest.fixture(scope="module", params=range(MODULES))
def types(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Types:
    name = f"Drawn{request.param}"
    text = Definitions(random.Random(seed() + request.param), name).text(TYPES)
    return Types(emitted.emit_text(tmp_path_factory.mktemp("random"), text))


@pytest.mark.sampled(2)
def test_round_trips(types: Types) -> None:
    for number in cases(EXAMPLES):
        draw = random.Random(number)
        descriptor = types.described[number % len(types.described)]
        value = Values(draw, types.anys).value(descriptor)
        little_endian = draw.random() < 0.5
        octets = types.octets(descriptor, value, little_endian)
        class_ = types.classes[descriptor.repository_id]
        again = class_.from_cdr(octets, little_endian)
        assert encoded(descriptor, again, little_endian) == octets
        assert (
            encoded(
                descriptor, decoded(descriptor, octets, little_endian), little_endian
            )
            == octets
        )
        if hasattr(value, "_snapshot_"):
            assert encoded(descriptor, value._snapshot_(), little_endian) == octets


def test_octets_cut_short_or_changed(types: Types) -> None:
    """Truncated octets are refused, changed ones are read or refused; only by CdrError."""
    for number in cases(EXAMPLES // 5):
        draw = random.Random(number)
        descriptor = types.described[number % len(types.described)]
        class_ = types.classes[descriptor.repository_id]
        octets = encoded(descriptor, Values(draw, types.anys).value(descriptor), True)
        places: Sequence[int] = range(len(octets))
        if len(octets) > SMALL:
            places = draw.sample(places, MAX_CUTS)
        for place in places:
            with pytest.raises(CdrError):
                class_.from_cdr(octets[:place])
            changed = bytearray(octets)
            changed[place] = draw.choice((0, 1, 0x7F, 0xFF, draw.randrange(256)))
            with suppress(CdrError):
                class_.from_cdr(changed)


def test_the_same_seed_gives_the_same_text() -> None:
    first, second = (Definitions(random.Random(5), "M").text(30) for _ in range(2))
    assert first == second
