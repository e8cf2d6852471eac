"""Generated conversions in this process, compared with omniORBpy's own marshalling."""

from __future__ import annotations

import importlib
import itertools
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import middleware

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))
sys.path.insert(0, str(Path(__file__).parents[1] / "interop"))

import random_types as random_types
import samples as samples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from padding import masked as masked
from padding import padding as padding

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.lowering.numeric import lower
from rtgen.compiler.lowering.settings import Settings
from rtgen.facts.numeric import Numeric
from rtgen.openrtm.backend.plan import Unit
from rtgen.openrtm.backend.wire_idl import WireIdl
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    ExceptionDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.values import encoded
from rtgen.runtime.openrtm import stubs

_numbers = itertools.count()
_EXAMPLES = 12


@dataclass(frozen=True)
class Kind:
    """A type with conversions: rtgen's class."""

    type: type[Any]

    @property
    def descriptor(self) -> Any:
        return self.type._descriptor_

    @property
    def is_exception(self) -> bool:
        return isinstance(self.descriptor, ExceptionDescriptor)

    @cached_property
    def conversions(self) -> Any:
        conversions = importlib.import_module("rtgen.runtime.openrtm.conversions")
        return conversions.conversions_of(self.descriptor)

    def new(self) -> Any:
        """Return a wire object with initial values."""
        return importlib.import_module("rtgen.runtime.openrtm.wire").new(self.type)

    def __getattr__(self, name: str) -> Any:
        """Return `fill`, `to` or `of`."""
        return getattr(self.conversions, name)

    @property
    def code(self) -> Any:
        """omniORB's type code."""
        omniorb = importlib.import_module("omniORB")
        return omniorb.findTypeCode(self.descriptor.repository_id)


class Wires:
    """A generated package, imported; `kinds` are the types that classic IDL has."""

    def __init__(self, package: str) -> None:
        self.package = package
        self.folder = Path(str(importlib.import_module(package).__file__)).parent
        self.types: dict[str, type[Any]] = {}
        for file in sorted(
            {*self.folder.glob("_idl/[a-z]*.py"), *self.folder.glob("[!_]*.py")}
            | {*self.folder.glob("[a-z]*/__init__.py"), *self.folder.glob("_views.py")}
        ):
            if file.stem.endswith("_calls"):
                continue
            path = file.relative_to(self.folder).with_suffix("").parts
            name = ".".join((package, *path)).removesuffix(".__init__")
            for type_ in _declared(importlib.import_module(name), name):
                self.types[type_._descriptor_.repository_id] = type_
        self.kinds = [Kind(type_) for type_ in self.types.values() if _is_known(type_)]

    def kind(self, scoped: str) -> Kind:
        """Return the type of that name."""
        return next(k for k in self.kinds if k.descriptor.name == scoped)

    def declared(self, name: str) -> Any:
        """Return a module of types and interfaces."""
        return importlib.import_module(f"{self.package}._idl.{name}")


def _is_known(type_: type[Any]) -> bool:
    """Return whether omniORB has a type of a struct, union or exception."""
    omniorb = importlib.import_module("omniORB")
    described = type_._descriptor_
    kinds = (StructDescriptor, UnionDescriptor, ExceptionDescriptor)
    known = omniorb.findType(described.repository_id)
    return isinstance(described, kinds) and known is not None


def _declared(scope: Any, module: str) -> Iterator[type[Any]]:
    """Yield the types in a module or an interface."""
    for value in vars(scope).values():
        own = isinstance(value, type) and value.__module__ == module
        if own and "_descriptor_" in vars(value):
            yield value
            yield from _declared(value, module)


def emit(folder: Path, paths: Sequence[Path], numeric: Numeric = "array") -> Unit:
    """Generate a package `wired_<number>` and a folder `idl` from IDL files."""
    result = load(paths, root=paths[0].parent)
    assert not has_errors(result.diagnostics), result.diagnostics
    options = Options(f"wired_{next(_numbers)}", "skeletons", "0.0.0", "openrtm")
    model = lower(result.model, Settings(numeric=numeric)).model
    unit = Unit(model, options)
    emission = BACKEND.emit(model, options)
    assert not emission.diagnostics
    for artifact in emission.artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    idl = WireIdl(unit)
    for file in unit.idl_files:
        path = folder / "idl" / f"{file.stem}.idl"
        path.parent.mkdir(exist_ok=True)
        path.write_text(idl.text(file), encoding="utf-8")
    return unit


def wired(folder: Path, paths: Sequence[Path], numeric: Numeric = "array") -> Wires:
    """Return the same, compiled by omniidl and imported."""
    unit = emit(folder, paths, numeric)
    made = folder / "stubs"
    made.mkdir()
    files = [folder / "idl" / f"{file.stem}.idl" for file in unit.idl_files]
    middleware.compile_idl(made, files, [folder / "idl"])
    stubs.load(made, [file.stem for file in unit.idl_files])
    return imported(folder, unit.options.package)


def wired_text(folder: Path, text: str, stem: str, numeric: Numeric = "array") -> Wires:
    """Return the same for one IDL text; `stem` is a name that no other test has."""
    path = folder / f"{stem}.idl"
    path.write_text(text, encoding="utf-8")
    return wired(folder, [path], numeric)


def imported(folder: Path, package: str) -> Wires:
    """Return a package in a folder, whose stubs are loaded."""
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        return Wires(package)
    finally:
        sys.path.remove(str(folder))


def stub_of(interface: Any, servant: Any) -> Any:
    """Return a stub that calls a servant in this process through omniORB."""
    wire = importlib.import_module("rtgen.runtime.openrtm.wire")
    reference = wire.objects_of(type(servant).__base__).to(servant)
    return wire.stub(interface, lambda: reference)


def marshalled(kind: Kind, wire: Any, little_endian: bool = True) -> bytes:
    """Return omniORB's octets; of an exception without the repository id in front."""
    omniorb = importlib.import_module("omniORB")
    octets: bytes = omniorb.cdrMarshal(kind.code, wire, int(little_endian))
    return octets


def agree(kind: Kind, value: Any, kept: Any, little_endian: bool) -> None:
    """Check that every conversion keeps a value, in octets and as an object.

    `kept` is a wire object that earlier values were filled into.
    """
    omniorb = importlib.import_module("omniORB")
    octets = value.to_cdr(little_endian)
    new = kind.to(value)
    sent = marshalled(kind, new, little_endian)
    if kind.is_exception:
        assert sent.endswith(octets[-1:])
        assert kind.of(new).to_cdr() == value.to_cdr()
        return
    places = padding(kind.descriptor, octets, little_endian)
    assert masked(sent, places) == octets
    kind.fill(kept, value)
    assert masked(marshalled(kind, kept, little_endian), places) == octets
    assert kind.of(new) == value
    assert kind.of(kept) == value
    if not holds(kind.descriptor, "wchar"):
        back = omniorb.cdrUnmarshal(kind.code, octets, int(little_endian))
        assert kind.of(back) == value


def values_agree(kind: Kind, all_types: dict[str, type[Any]]) -> None:
    """Check random values of a type, which are filled into one wire object."""
    descriptor = kind.descriptor
    kept = None if kind.is_exception else kind.new()

    @settings(
        max_examples=_EXAMPLES,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(samples.values(descriptor), st.booleans())
    def check(tree: Any, little_endian: bool) -> None:
        value = samples.build(descriptor, tree, all_types)
        agree(kind, value, kept, little_endian)

    check()


def holds(
    descriptor: Descriptor, primitive: str, seen: frozenset[str] = frozenset()
) -> bool:
    """Return whether a type contains a primitive; omniORBpy 4.3.3 cannot read a wchar it wrote."""
    found: Any = plain(descriptor)
    name = getattr(found, "repository_id", "")
    if name and name in seen:
        return False
    seen |= {name}
    match found:
        case StructDescriptor(members=fields) | ExceptionDescriptor(members=fields):
            return any(holds(m.type, primitive, seen) for m in fields)
        case UnionDescriptor() as union:
            parts = [union.switch, *(branch.type for branch in union.branches)]
            return any(holds(part, primitive, seen) for part in parts)
        case SequenceDescriptor(element) | ArrayDescriptor(element):
            return holds(element, primitive, seen)
    return bool(found == PrimitiveDescriptor(primitive))


def type_codes(wires: Wires) -> Iterator[Any]:
    """Yield the descriptors of all types of a package that omniORB knows."""
    omniorb = importlib.import_module("omniORB")
    for type_ in wires.types.values():
        if omniorb.findTypeCode(type_._descriptor_.repository_id) is not None:
            yield type_._descriptor_


def equal_type_codes(descriptor: Any) -> bool:
    """Return whether omniORB's type code equals rtgen's, names and aliases included."""
    omniorb = importlib.import_module("omniORB")
    corba = importlib.import_module("omniORB.CORBA")
    octets = encoded(PrimitiveDescriptor("CORBA::TypeCode"), descriptor, True)
    ours = omniorb.cdrUnmarshal(corba.TC_TypeCode, octets, 1)
    theirs = omniorb.findTypeCode(descriptor.repository_id)
    return bool(theirs.equal(ours))
