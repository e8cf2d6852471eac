"""Random types and values against omniORBpy: the same octets, both ways.

What is known of omniORBpy 4.3.3, and allowed for: padding is uninitialised; a wchar that it wrote
it cannot read; values above 2**63 - 1 in sequences of unsigned long long raise; long double is not
supported. Values with state can make it abort (nested ones in the other byte order) or marshal
without end, and their chunks end where its buffer does: here they are null, and a test of their own
has those that it can do. An exception has its repository id in front, as in an any.

`RTGEN_CDR_EXAMPLES` is the number of values in all, 10,000 if it is not set.
"""

from __future__ import annotations

import importlib
import os
import random
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "unit" / "types"))

import emitted
from padding import masked, padding
from random_types import Definitions, Values

from rtgen.runtime import type_codes
from rtgen.runtime.cdr_faults import decoded, encoded
from rtgen.runtime.descriptors import (
    NULL,
    AliasDescriptor,
    ArrayDescriptor,
    BoxDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)

MODULES = 8
TYPES = 30
EXAMPLES = int(os.environ.get("RTGEN_CDR_EXAMPLES", "10000")) // MODULES
TYPE_CODE = PrimitiveDescriptor("CORBA::TypeCode")
SIMPLE: tuple[Descriptor, ...] = (
    NULL,
    *(PrimitiveDescriptor(n) for n in ("long", "double", "boolean", "octet", "any")),
    *(TYPE_CODE, StringDescriptor(), StringDescriptor(True)),
)


class Peers:
    """Our package and omniORBpy's module for one definition."""

    def __init__(self, ours: Any, theirs: Any, orb: Any) -> None:
        self.theirs = theirs
        self.corba = orb
        self.omniorb = importlib.import_module("omniORB")
        self.classes = {t._descriptor_.repository_id: t for t in _described(ours)}
        self.types = [t._descriptor_ for t in self.classes.values()]
        held = [t for t in self.types if not Traits(t).wchar]
        self.anys: list[Descriptor] = [*SIMPLE, *held]

    def type_code(self, descriptor: Any) -> Any:
        """Theirs for one of ours."""
        match descriptor:
            case PrimitiveDescriptor(name):
                short = name.removeprefix("CORBA::").replace(" ", "")
                return getattr(self.corba, f"_tc_{short}")
            case StringDescriptor(wide):
                return self.corba._tc_wstring if wide else self.corba._tc_string
        return getattr(self.theirs, f"_tc_{descriptor.name.rpartition('::')[2]}")

    def converted(self, descriptor: Any, value: Any, memo: dict[int, Any]) -> Any:
        """Our value as theirs; what is shared stays shared."""
        match descriptor:
            case LinkDescriptor() | AliasDescriptor():
                return self.converted(plain(descriptor), value, memo)
            case PrimitiveDescriptor("any"):
                inner = self.converted(value.type, value.value, memo)
                return self.corba.Any(self.type_code(value.type), inner)
            case PrimitiveDescriptor("CORBA::TypeCode"):
                return self.type_code(value)
            case FixedDescriptor(digits, scale):
                return self.omniorb.fixed(digits, scale, f"{value:f}")
            case SequenceDescriptor(element) if isinstance(value, list):
                return [self.converted(element, item, memo) for item in value]
            case ArrayDescriptor(element, dimensions) if isinstance(value, list):
                rest = dimensions[1:]
                inner = ArrayDescriptor(element, rest) if rest else element
                return [self.converted(inner, item, memo) for item in value]
            case EnumDescriptor():
                return self._class(descriptor)._items[int(value)]
            case StructDescriptor(members=members) | ExceptionDescriptor(
                members=members
            ):
                parts = [
                    self.converted(m.type, getattr(value, m.attribute), memo)
                    for m in members
                ]
                return self._class(descriptor)(*parts)
            case UnionDescriptor():
                branch = descriptor.branch(value.discriminator)
                chosen = self.converted(descriptor.switch, value.discriminator, memo)
                inner = None
                if branch is not None:
                    inner = self.converted(branch.type, value.value, memo)
                return self._class(descriptor)(chosen, inner)
            case BoxDescriptor(target=target):
                if value is None:
                    return None
                if id(value) not in memo:
                    memo[id(value)] = self.converted(target, value.value, memo)
                return memo[id(value)]
        return value

    def _class(self, descriptor: Any) -> Any:
        return getattr(self.theirs, descriptor.name.rpartition("::")[2])


class Traits:
    """Whether a type holds a wchar, and whether it holds type codes."""

    def __init__(self, descriptor: Descriptor) -> None:
        self.wchar = self.dynamic = False
        self._seen: set[str] = set()
        self._look(descriptor)

    def _look(self, descriptor: Any) -> None:
        descriptor = plain(descriptor)
        name = getattr(descriptor, "repository_id", "")
        if name in self._seen:
            return
        self._seen |= {name} - {""}
        match descriptor:
            case PrimitiveDescriptor(kind):
                self.wchar |= kind == "wchar"
                self.dynamic |= kind in ("any", "CORBA::TypeCode")
            case SequenceDescriptor(element) | ArrayDescriptor(element):
                self._look(element)
            case StructDescriptor(members=members) | ExceptionDescriptor(
                members=members
            ):
                for member in members:
                    self._look(member.type)
            case UnionDescriptor(switch=switch, branches=branches):
                self._look(switch)
                for branch in branches:
                    self._look(branch.type)
            case ValueDescriptor():
                for member in descriptor.all_members():
                    self._look(member.type)
            case BoxDescriptor(target=target):
                self._look(target)


def _described(package: Any) -> Iterator[Any]:
    kinds = (StructDescriptor, UnionDescriptor, EnumDescriptor, AliasDescriptor)
    for type_ in emitted.classes(package):
        if isinstance(
            type_._descriptor_,
            (*kinds, ExceptionDescriptor, ValueDescriptor, BoxDescriptor),
        ):
            yield type_


@pytest.fixture(scope="module")
def orb() -> Iterator[Any]:
    pytest.importorskip("omniORB", reason="omniORBpy is not installed")
    corba = importlib.import_module("omniORB.CORBA")
    made = corba.ORB_init(["rtgen", "-ORBnativeCharCodeSet", "UTF-8"])
    yield corba
    made.destroy()


@pytest.fixture(scope="module")
def omniidl() -> str:
    scripts = sysconfig.get_path("scripts")
    found = shutil.which("omniidl", path=scripts) or shutil.which("omniidl")
    if found is None:
        pytest.skip("omniidl is not installed")
    return found


@pytest.fixture(scope="module", params=range(MODULES))
def peers(
    request: pytest.FixtureRequest,
    orb: Any,
    omniidl: str,
    tmp_path_factory: pytest.TempPathFactory,
) -> Peers:
    seed = request.param
    folder = tmp_path_factory.mktemp(f"random{seed}")
    text = Definitions(seed, f"Random{seed}").text(TYPES)
    file = folder / f"random{seed}.idl"
    file.write_text(text, encoding="utf-8")
    theirs = folder / "theirs"
    theirs.mkdir()
    command = [omniidl, "-bpython", f"-C{theirs}", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    package = emitted.emit(folder, [file])
    sys.path.insert(0, str(theirs))
    try:
        module = importlib.import_module(f"Random{seed}")
    finally:
        sys.path.remove(str(theirs))
    return Peers(package, module, orb)


def all_padding(descriptor: Any, value: Any, little_endian: bool) -> list[int]:
    """Where padding lies, that within type codes too: it is what changes with the filler."""
    plainly = encoded(descriptor, value, little_endian)
    align = type_codes._Writer._align
    with pytest.MonkeyPatch.context() as patch:

        def filled(self: Any, size: int) -> None:
            before = len(self.out)
            align(self, size)
            self.out[before:] = b"\xa5" * (len(self.out) - before)

        patch.setattr(type_codes._Writer, "_align", filled)
        other = encoded(descriptor, value, little_endian)
    filler = [i for i, (a, b) in enumerate(zip(plainly, other, strict=True)) if a != b]
    return filler + padding(descriptor, plainly, little_endian)


def test_type_codes(peers: Peers) -> None:
    for descriptor in peers.types:
        for little_endian in (True, False):
            octets = encoded(TYPE_CODE, descriptor, little_endian)
            theirs = peers.omniorb.cdrMarshal(
                peers.corba._tc_TypeCode,
                peers.type_code(descriptor),
                int(little_endian),
            )
            places = all_padding(TYPE_CODE, descriptor, little_endian)
            assert masked(octets, places) == masked(theirs, places), descriptor.name
            back = decoded(TYPE_CODE, theirs, little_endian)
            assert encoded(TYPE_CODE, back, little_endian) == octets, descriptor.name


def test_values(peers: Peers) -> None:
    types = [
        t
        for t in peers.types
        if not isinstance(t, ExceptionDescriptor | ValueDescriptor)
    ]
    traits = [Traits(t) for t in types]
    for number in range(EXAMPLES):
        draw = random.Random(number)
        index = number % len(types)
        drawn = Values(draw, peers.anys, state=False)
        little_endian = draw.random() < 0.5
        try:
            compare(peers, types[index], traits[index], drawn, little_endian)
        except Exception as error:
            error.add_note(f"example {number}: {types[index].name}")
            raise


def compare(
    peers: Peers, descriptor: Any, traits: Traits, drawn: Values, little_endian: bool
) -> None:
    order = int(little_endian)
    value = drawn.value(descriptor)
    octets = encoded(descriptor, value, little_endian)
    class_ = peers.classes[descriptor.repository_id]
    if isinstance(descriptor, AliasDescriptor):
        assert class_.to_cdr(value, little_endian) == octets
    elif value is not None:
        assert value.to_cdr(little_endian) == octets
    code = peers.type_code(descriptor)
    peer = peers.converted(descriptor, value, {})
    theirs = peers.omniorb.cdrMarshal(code, peer, order)
    if traits.dynamic:
        places = all_padding(descriptor, value, little_endian)
    else:
        places = padding(descriptor, octets, little_endian)
    assert octets == masked(theirs, places)
    back = class_.from_cdr(theirs, little_endian)
    assert encoded(descriptor, back, little_endian) == octets
    if not traits.wchar:
        read = peers.omniorb.cdrUnmarshal(code, octets, order)
        returned = peers.omniorb.cdrMarshal(code, read, order)
        assert octets == masked(returned, places)
