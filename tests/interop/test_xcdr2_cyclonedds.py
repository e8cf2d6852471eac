"""XCDR compared with cyclonedds: random types, random values, the same octets both ways.

Each set of types is compiled by rtgen and written as classes of cyclonedds; then many values go
both ways, in both byte orders, as XCDR2 and, where cyclonedds follows DDS-XTypes, as XCDR1.

What cyclonedds 11.0 does differently from DDS-XTypes 1.3 is not drawn here; test_xcdr.py has the
octets that the standard requires:

- maps of strings or constructed types have no DHEADER (rule 14 requires one);
- enums with a `bit_bound` that is not 8, 16 or 32 take a wrong size, in XCDR1 all take 4 octets;
- `@must_understand` on an optional member of a final struct sets the wrong bit in XCDR1;
- a discriminator that selects nothing in an appendable union is read as another one;
- mutable unions, `long double`, `wstring` and bitsets are not there.
"""

from __future__ import annotations

import importlib
import random
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import dds_types as dds
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from seeds import budget

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted

from rtgen.runtime import xcdr

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from cyclonedds.idl._support import Endianness

TYPE_SETS = budget(30)
VALUES = 120
ORDERS = {True: Endianness.Little, False: Endianness.Big}


@dataclass(frozen=True)
class Sides:
    """Both sides of a set of types."""

    ours: ModuleType
    theirs: ModuleType


_made = 0


def sides(folder: Path, declared: tuple[dds.Declared, ...]) -> Sides:
    """Compile the types for both sides."""
    global _made
    _made += 1
    idl = folder / f"set{_made}.idl"
    idl.write_text(dds.Idl(declared).text, encoding="utf-8")
    ours = emitted.emit(folder, [idl])
    name = f"cyclone_set{_made}"
    (folder / f"{name}.py").write_text(dds.cyclone_text(declared), encoding="utf-8")
    sys.path.insert(0, str(folder))
    try:
        theirs = importlib.import_module(name)
    finally:
        sys.path.remove(str(folder))
    theirs.OWNERS = {d.name: d for d in declared}
    return Sides(ours, theirs)


def is_plain_in_xcdr1(declared: dds.Struct | dds.Union) -> bool:
    """Return whether cyclonedds encodes the type in XCDR1 as the standard does."""
    for type_ in dds.parts(declared):
        match type_:
            case dds.Enum(bound=bound) if bound in (8, 16):
                return False
            case dds.Struct(extensibility="final" | "appendable"):
                if any(m.optional and m.must_understand for m in type_.everything):
                    return False
    return True


def compare(
    pair: Sides, type_: dds.Struct | dds.Union, neutral: Any, versions: tuple[int, ...]
) -> None:
    """Compare one value, both ways, in each version and byte order."""
    ours_class = getattr(pair.ours, type_.name)
    theirs_class = getattr(pair.theirs, type_.name)
    ours = dds.to_ours(type_, neutral, pair.ours)
    theirs = dds.to_theirs(type_, neutral, pair.theirs)
    for version in versions:
        for little, order in ORDERS.items():
            representation = xcdr.representation_of(ours_class, version, little)
            expected = theirs.serialize(endianness=order, use_version_2=version == 2)
            payload = xcdr.serialize(ours, representation)
            padding = -len(expected) % 4
            assert payload[:2] == expected[:2]
            assert payload[3] == padding
            assert payload[4:] == expected[4:] + bytes(padding)
            assert xcdr.deserialize(ours_class, expected) == ours
            back = theirs_class.deserialize(payload)
            assert dds.from_theirs(type_, back, pair.theirs) == neutral


@pytest.mark.nightly
@settings(
    max_examples=TYPE_SETS,
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.generate, Phase.shrink],
)
@given(
    declared=dds.type_sets(),
    draw=st.randoms(use_true_random=False),
    seed=st.integers(0, 1 << 32),
)
def test_random_types_are_the_same_octets(
    tmp_path_factory: pytest.TempPathFactory,
    declared: tuple[dds.Declared, ...],
    draw: random.Random,
    seed: int,
) -> None:
    """hypothesis draws the types and the first value, and minimizes failures."""
    pair = sides(tmp_path_factory.mktemp("set"), declared)
    first, others = dds.Values(draw), dds.Values(random.Random(seed))
    types = [d for d in declared if isinstance(d, dds.Struct | dds.Union)]
    versions = {t.name: (1, 2) if is_plain_in_xcdr1(t) else (2,) for t in types}
    for number in range(VALUES):
        # The last type, which may use all others, gets every other value.
        type_ = types[-1] if number % 2 else types[number // 2 % len(types)]
        value = (others if number else first).of(type_)
        try:
            compare(pair, type_, value, versions[type_.name])
        except Exception as error:
            error.add_note(f"{type_.name}: {value!r}\n{dds.Idl(declared).text}")
            raise
