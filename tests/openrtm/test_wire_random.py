"""Random types through the conversions, with random values."""

from __future__ import annotations

import importlib
import random
from pathlib import Path
from typing import Any

import pytest
from wires import Kind, equal_type_codes, holds, random_types, type_codes, wired_text

from rtgen.runtime.marshalling.descriptors import (
    NULL,
    PrimitiveDescriptor,
    StringDescriptor,
    ValueDescriptor,
)
from rtgen.runtime.marshalling.dynamic.values import encoded

TYPES = 20
VALUES = 6
ANYS = [NULL, StringDescriptor(), PrimitiveDescriptor("long")]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(3))
def test_random_types(seed: int, orb: Any, tmp_path: Path) -> None:
    draw = random.Random(seed)
    name = f"WiredRandom{seed}"
    text = random_types.Definitions(draw, name).text(TYPES)
    wires = wired_text(tmp_path, text, f"wired_random_{seed}")
    for descriptor in type_codes(wires):
        assert equal_type_codes(descriptor), descriptor.name
    stateful = [t._descriptor_ for t in wires.types.values()]
    anys = [*ANYS, *(d for d in stateful if isinstance(d, ValueDescriptor))]
    for kind in wires.kinds:
        if holds(kind.descriptor, "wchar"):
            continue
        values = random_types.Values(draw, anys, state=False)
        kept = None if kind.is_exception else kind.new()
        for _ in range(VALUES):
            compare(kind, values.value(kind.descriptor), kept)


def compare(kind: Kind, value: Any, kept: Any) -> None:
    """Check that a value has equal octets by a new and by a reused wire object."""
    octets = encoded(kind.descriptor, value, True)
    made = [kind.to(value)]
    if kept is not None:
        kind.fill(kept, value)
        made.append(kept)
    for wire in made:
        again = kind.of(wire)
        assert encoded(kind.descriptor, again, True) == octets, (value, again)
        sent = importlib.import_module("omniORB").cdrMarshal(kind.code, wire, 1)
        if not kind.is_exception:
            assert encoded(kind.descriptor, kind.type.from_cdr(sent), True) == octets
