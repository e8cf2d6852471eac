"""Every reference type through the generated conversions: omniORBpy's octets are ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from wires import Kind, Wires, agree, marshalled, samples, wired

SPECS = Path(__file__).parents[2] / "specs"
INTEROP = Path(__file__).parents[1] / "interop"
EXAMPLES = 12


@pytest.fixture(scope="module")
def types(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> Wires:
    """OpenRTM's types and those of the reference."""
    files = sorted((SPECS / "idl").glob("*.idl"))
    return wired(tmp_path_factory.mktemp("reference"), files)


def values_agree(kind: Kind, all_types: dict[str, type[Any]]) -> None:
    """Random values of a type, which are filled into one wire object after the other."""
    descriptor = kind.descriptor
    kept = None if kind.is_exception else kind.new()

    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(samples.values(descriptor), st.booleans())
    def check(tree: Any, little_endian: bool) -> None:
        value = samples.build(descriptor, tree, all_types)
        agree(kind, value, kept, little_endian)

    check()


def test_every_reference_type(types: Wires) -> None:
    assert len(types.kinds) > 120
    for kind in types.kinds:
        values_agree(kind, types.types)


def test_initial_values_can_be_marshalled(types: Wires) -> None:
    for kind in types.kinds:
        octets = kind.type().to_cdr()
        assert len(marshalled(kind, kind.new())) == len(octets)
        assert kind.of(kind.new()) == kind.type()
