"""Every reference type compared with omniORBpy: equal octets in both byte orders, both ways.

omniORBpy leaves padding uninitialised, so it is masked in omniORBpy's octets; rtgen's must be zero.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import programs
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted
import samples
from padding import masked, padding
from seeds import budget

from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    EnumDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    plain,
)

SPECS = Path(__file__).parents[2] / "specs" / "idl"
FILES = sorted(SPECS.glob("*.idl"))
EXAMPLES = budget(25)


@dataclass(frozen=True)
class Peers:
    """Both mappings: rtgen's classes and omniORBpy's modules, and its marshalling functions."""

    ours: dict[str, type[Any]]
    modules: dict[str, Any]
    marshal: Any
    unmarshal: Any

    def theirs(self, descriptor: StructDescriptor | EnumDescriptor) -> Any:
        """Return the omniORBpy class of a type, or the enum's item list holder."""
        return getattr(*self._place(descriptor, ""))

    def type_code(self, descriptor: StructDescriptor) -> Any:
        return getattr(*self._place(descriptor, "_tc_"))

    def _place(self, descriptor: Any, prefix: str) -> tuple[Any, str]:
        scope, _, name = descriptor.name.rpartition("::")
        return self.modules[scope or "_GlobalIDL"], prefix + name


@pytest.fixture(scope="module")
def peers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Peers]:
    omniorb = pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    folder = tmp_path_factory.mktemp("omniorb")
    for path in FILES:
        command = [
            programs.omniidl(),
            "-bpython",
            f"-I{SPECS}",
            f"-C{folder}",
            str(path),
        ]
        subprocess.run(command, check=True, capture_output=True)
    package = emitted.emit(tmp_path_factory.mktemp("ours"), FILES)
    ours = {t._descriptor_.repository_id: t for t in _declared(package)}
    orb_module = importlib.import_module("omniORB.CORBA")
    orb = orb_module.ORB_init(["rtgen", "-ORBnativeCharCodeSet", "UTF-8"])
    scopes = {
        t._descriptor_.name.rpartition("::")[0] or "_GlobalIDL" for t in ours.values()
    }
    sys.path.insert(0, str(folder))
    try:
        modules = {scope: importlib.import_module(scope) for scope in sorted(scopes)}
    finally:
        sys.path.remove(str(folder))
    yield Peers(ours, modules, omniorb.cdrMarshal, omniorb.cdrUnmarshal)
    orb.destroy()
    # Other tests need all of OpenRTM's RTC.
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", None)).startswith(str(folder)):
            del sys.modules[name]


def _declared(package: Any) -> Iterator[type[Any]]:
    for type_ in emitted.classes(package):
        if isinstance(type_._descriptor_, StructDescriptor | EnumDescriptor):
            yield type_


def to_theirs(peers: Peers, descriptor: Descriptor, tree: Any) -> Any:
    descriptor = plain(descriptor)
    match descriptor:
        case StructDescriptor(members=fields):
            parts = [to_theirs(peers, m.type, tree[m.name]) for m in fields]
            return peers.theirs(descriptor)(*parts)
        case EnumDescriptor():
            return peers.theirs(descriptor)._items[tree]
        case SequenceDescriptor(element) if isinstance(tree, list):
            return [to_theirs(peers, element, item) for item in tree]
        case ArrayDescriptor(element, (_,)) if isinstance(tree, list):
            return [to_theirs(peers, element, item) for item in tree]
    return tree


def from_theirs(descriptor: Descriptor, value: Any) -> Any:
    descriptor = plain(descriptor)
    match descriptor:
        case StructDescriptor(members=fields):
            return {m.name: from_theirs(m.type, getattr(value, m.name)) for m in fields}
        case EnumDescriptor():
            return value._v
        case SequenceDescriptor(element) | ArrayDescriptor(element) if isinstance(
            value, list
        ):
            return [from_theirs(element, item) for item in value]
        case PrimitiveDescriptor("boolean"):
            return bool(value)
    return value


def holds_wchar(descriptor: Descriptor) -> bool:
    """Return whether the type contains a wchar: omniORBpy 4.3.3 cannot read those that it wrote."""
    descriptor = plain(descriptor)
    match descriptor:
        case StructDescriptor(members=fields):
            return any(holds_wchar(member.type) for member in fields)
        case SequenceDescriptor(element) | ArrayDescriptor(element):
            return holds_wchar(element)
    return descriptor == PrimitiveDescriptor("wchar")


@pytest.mark.nightly
def test_every_reference_type(peers: Peers) -> None:
    structs = [
        t for t in peers.ours.values() if isinstance(t._descriptor_, StructDescriptor)
    ]
    assert len(structs) > 100
    for type_ in structs:
        agree(peers, type_)


def agree(peers: Peers, type_: type[Any]) -> None:
    """Compare random values of the type in both codecs."""
    descriptor = type_._descriptor_
    code = peers.type_code(descriptor)

    @settings(
        max_examples=EXAMPLES,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(samples.values(descriptor), st.booleans())
    def check(tree: Any, little_endian: bool) -> None:
        ours = samples.build(descriptor, tree, peers.ours)
        octets = ours.to_cdr(little_endian)
        theirs = to_theirs(peers, descriptor, tree)
        their_octets = peers.marshal(code, theirs, int(little_endian))
        places = padding(descriptor, octets, little_endian)
        assert octets == masked(their_octets, places)
        assert all(octets[place] == 0 for place in places)
        assert type_.from_cdr(their_octets, little_endian) == ours
        if not holds_wchar(descriptor):
            back = peers.unmarshal(code, octets, int(little_endian))
            assert from_theirs(descriptor, back) == tree

    check()
