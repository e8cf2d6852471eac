"""Every reference type through the generated conversions: omniORBpy's octets are ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from wires import Wires, marshalled, values_agree, wired

SPECS = Path(__file__).parents[2] / "specs"


@pytest.fixture(scope="module")
def types(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> Wires:
    """OpenRTM's types and those of the reference."""
    files = sorted((SPECS / "idl").glob("*.idl"))
    return wired(tmp_path_factory.mktemp("reference"), files)


def test_every_reference_type(types: Wires) -> None:
    assert len(types.kinds) > 120
    for kind in types.kinds:
        values_agree(kind, types.types)


def test_initial_values_can_be_marshalled(types: Wires) -> None:
    for kind in types.kinds:
        octets = kind.type().to_cdr()
        assert len(marshalled(kind, kind.new())) == len(octets)
        assert kind.of(kind.new()) == kind.type()
