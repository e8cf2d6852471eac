"""Every reference type in the generated conversions: omniORBpy's octets equal rtgen's."""

from __future__ import annotations

import copy
import importlib
from pathlib import Path
from typing import Any

import pytest
from wires import Wires, marshalled, values_agree, wired

SPECS = Path(__file__).parents[2] / "specs"


@pytest.fixture(scope="module")
def types(orb: Any, tmp_path_factory: pytest.TempPathFactory) -> Wires:
    """Return OpenRTM's types and those of the reference build."""
    files = sorted((SPECS / "idl").glob("*.idl"))
    return wired(tmp_path_factory.mktemp("reference"), files)


@pytest.mark.nightly
def test_every_reference_type(types: Wires) -> None:
    assert len(types.kinds) > 120
    for kind in types.kinds:
        values_agree(kind, types.types)


@pytest.mark.sampled(0)
def test_initial_values_can_be_marshalled(types: Wires) -> None:
    for kind in types.kinds:
        octets = kind.type().to_cdr()
        assert len(marshalled(kind, kind.new())) == len(octets)
        assert kind.of(kind.new()) == kind.type()


def test_openrtm_can_copy_initial_values(types: Wires) -> None:
    """An OutPort stores a deep copy of its initial value, and reads its type."""
    any_ = importlib.import_module("omniORB.any")
    for kind in types.kinds:
        if kind.is_exception:
            continue
        copied = copy.deepcopy(kind.new())
        assert any_.to_any(copied).typecode().id() == kind.descriptor.repository_id
        assert kind.of(copied) == kind.type()
