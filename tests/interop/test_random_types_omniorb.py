"""Random types and values compared with omniORBpy: the same octets, both ways.

hypothesis draws types and values, and minimizes failures. For most values the types are compiled
once (`test_values`); a few sets of types are drawn by hypothesis (`test_types`), so that a failing
type is minimized, too. omniORBpy runs in a process of its own.

Known properties of omniORBpy 4.3.3: padding is uninitialised; it cannot read a wchar that it wrote;
values above 2**63 - 1 in sequences of unsigned long long raise; long double is not supported.
Values with state can make it abort (nested ones in the other byte order) or marshal without end,
and their chunks end where its buffer does: here they are null, and a separate test has those that
work. An exception has its repository id in front, as in an any.

`RTGEN_BUDGET` multiplies the number of values, and `RTGEN_SEED` draws others (see `seeds`).
"""

from __future__ import annotations

import importlib.util
import itertools
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import programs
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

sys.path.insert(0, str(Path(__file__).parents[1] / "compiler" / "types"))

import emitted
from omniorb_peer import (
    TYPE_CODE,
    Code,
    Convert,
    Load,
    Peer,
    Reference,
    octets_of,
    value_of,
)
from padding import masked, padding
from random_types import BITS, Definitions, Values
from seeds import budget, seed

from rtgen.runtime.marshalling import type_codes
from rtgen.runtime.marshalling.descriptors import (
    NULL,
    AliasDescriptor,
    ArrayDescriptor,
    BoxDescriptor,
    Descriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.values import decoded, encoded
from rtgen.runtime.marshalling.octets import ObjectReference

MODULES = 8
TYPES = 30
EXAMPLES = budget(1000) // MODULES
SMALL_MODULES = budget(8)
SMALL = 4
SMALL_VALUES = 40
_LONG = PrimitiveDescriptor("long")
SIMPLE: tuple[Descriptor, ...] = (
    NULL,
    *(PrimitiveDescriptor(n) for n in (*BITS, "float", "double", "boolean", "char")),
    *(PrimitiveDescriptor(n) for n in ("any", "Object")),
    TYPE_CODE,
    *(StringDescriptor(), StringDescriptor(True)),
    *(StringDescriptor(False, 5), StringDescriptor(True, 4), FixedDescriptor(5, 2)),
    *(SequenceDescriptor(_LONG), SequenceDescriptor(PrimitiveDescriptor("any"), 3)),
    SequenceDescriptor(ArrayDescriptor(StringDescriptor(), (2,))),
    ArrayDescriptor(_LONG, (2, 3)),
)
"""Possible types in an any besides those of a module."""

DRAWN = settings(
    deadline=None,
    database=None,
    phases=[Phase.generate, Phase.shrink],
    suppress_health_check=[
        HealthCheck.too_slow,
        HealthCheck.data_too_large,
        HealthCheck.large_base_example,
        HealthCheck.function_scoped_fixture,
    ],
)
_numbers = itertools.count()
REFERENCES = (
    "corbaloc::1.2@localhost:2809/Key1",
    "corbaloc::1.0@localhost:2810/K",
    "corbaloc::1.2@localhost:2809,:1.1@127.0.0.1:1/a%20name",
)


class Types:
    """A module of rtgen that the process has loaded, too."""

    def __init__(
        self,
        peer: Peer,
        references: tuple[ObjectReference, ...],
        text: str,
        package: Any,
    ) -> None:
        self.peer = peer
        self.text = text
        self.references = references
        kinds = (StructDescriptor, UnionDescriptor, EnumDescriptor, AliasDescriptor)
        kinds += (ExceptionDescriptor, ValueDescriptor, BoxDescriptor)
        found = [
            t for t in emitted.classes(package) if isinstance(t._descriptor_, kinds)
        ]
        self.classes = {t._descriptor_.repository_id: t for t in found}
        self.all = [t._descriptor_ for t in self.classes.values()]
        self.traits = {t.repository_id: Traits(t) for t in self.all}
        held = [t for t in self.all if not self.traits[t.repository_id].wchar]
        self.anys: list[Descriptor] = [*SIMPLE, *held]
        self.compared = [t for t in self.all if not isinstance(t, ValueDescriptor)]

    def compare(self, draw: random.Random, descriptor: Any) -> None:
        """Compare a value of the type, both ways."""
        values = Values(draw, self.anys, state=False, references=self.references)
        little_endian = draw.random() < 0.5
        value = values.value(descriptor)
        try:
            self._compare(descriptor, value, little_endian)
        except Exception as error:
            error.add_note(f"{descriptor.name}, {little_endian=}: {value!r}")
            raise

    def _compare(self, descriptor: Any, value: Any, little_endian: bool) -> None:
        octets = octets_of(descriptor, value, little_endian)
        class_ = self.classes[descriptor.repository_id]
        body = octets
        if isinstance(descriptor, ExceptionDescriptor):
            body = encoded(descriptor, value, little_endian)
        if isinstance(descriptor, AliasDescriptor):
            assert class_.to_cdr(value, little_endian) == body
        elif value is not None:
            assert value.to_cdr(little_endian) == body
        traits = self.traits[descriptor.repository_id]
        theirs, returned = self.peer.ask(
            Convert(descriptor.repository_id, octets, little_endian, not traits.wchar)
        )
        unset = places(descriptor, octets, little_endian)
        if octets != masked(theirs, unset) and traits.dynamic:
            unset = all_padding(descriptor, value, little_endian)
        assert octets == masked(theirs, unset)
        if returned is not None and octets != masked(returned, unset):
            unset = all_padding(descriptor, value, little_endian)
            assert octets == masked(returned, unset)
        back = value_of(descriptor, theirs, little_endian)
        assert octets_of(descriptor, back, little_endian) == octets
        if body is octets:
            again = class_.from_cdr(theirs, little_endian)
            assert encoded(descriptor, again, little_endian) == octets

    def compare_type_code(self, descriptor: Any, little_endian: bool) -> None:
        """Compare the type code of the type, both ways."""
        octets = encoded(TYPE_CODE, descriptor, little_endian)
        theirs = self.peer.ask(Code(descriptor.repository_id, little_endian))
        unset = all_padding(TYPE_CODE, descriptor, little_endian)
        assert octets == masked(theirs, unset), descriptor.name
        back = decoded(TYPE_CODE, theirs, little_endian)
        assert encoded(TYPE_CODE, back, little_endian) == octets, descriptor.name


class Traits:
    """Whether a type contains a wchar, and whether it contains type codes."""

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


def all_padding(descriptor: Any, value: Any, little_endian: bool) -> list[int]:
    """Return the positions of padding, also in type codes: octets that vary with the filler."""
    plainly = octets_of(descriptor, value, little_endian)
    align = type_codes._Writer._align
    with pytest.MonkeyPatch.context() as patch:

        def filled(self: Any, size: int) -> None:
            before = len(self.out)
            align(self, size)
            self.out[before:] = b"\xa5" * (len(self.out) - before)

        patch.setattr(type_codes._Writer, "_align", filled)
        patch.setattr(type_codes, "_WRITTEN", {})
        other = octets_of(descriptor, value, little_endian)
    filler = [i for i, (a, b) in enumerate(zip(plainly, other, strict=True)) if a != b]
    return filler + places(descriptor, plainly, little_endian)


def places(descriptor: Any, octets: bytes, little_endian: bool) -> list[int]:
    """Return the positions of padding in the result of `octets_of`."""
    identified = isinstance(descriptor, ExceptionDescriptor)
    return padding(descriptor, octets, little_endian, identified=identified)


@pytest.fixture(scope="module")
def peer() -> Iterator[Peer]:
    if importlib.util.find_spec("omniORB") is None:
        pytest.skip("omniORBpy is not installed")
    made = Peer()
    yield made
    made.close()


@pytest.fixture(scope="module")
def references(peer: Peer) -> tuple[ObjectReference, ...]:
    object_ = PrimitiveDescriptor("Object")
    made = [decoded(object_, peer.ask(Reference(text)), True) for text in REFERENCES]
    assert all(isinstance(reference, ObjectReference) for reference in made)
    return tuple(made)


def compiled(
    peer: Peer,
    references: tuple[ObjectReference, ...],
    folder: Path,
    draw: random.Random,
    size: int,
) -> Types:
    """Return a random module on both sides."""
    number = next(_numbers)
    name = f"Random{number}"
    folder = folder / name
    theirs = folder / "theirs"
    theirs.mkdir(parents=True)
    file = folder / f"random{number}.idl"
    text = Definitions(draw, name).text(size)
    file.write_text(text, encoding="utf-8")
    command = [programs.omniidl(), "-bpython", f"-C{theirs}", str(file)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    package = emitted.emit(folder, [file])
    peer.load(Load(str(folder), package.__name__, str(theirs), name))
    return Types(peer, references, text, package)


@pytest.fixture(scope="module", params=range(MODULES))
def types(
    request: pytest.FixtureRequest,
    peer: Peer,
    references: tuple[ObjectReference, ...],
    tmp_path_factory: pytest.TempPathFactory,
) -> Types:
    folder = tmp_path_factory.mktemp("random")
    draw = random.Random(seed() + request.param)
    return compiled(peer, references, folder, draw, TYPES)


@pytest.mark.sampled(2)
def test_type_codes(types: Types) -> None:
    for descriptor in types.all:
        for little_endian in (True, False):
            types.compare_type_code(descriptor, little_endian)


def test_a_process_that_ends_is_reported_and_started_again(peer: Peer) -> None:
    peer.ask(Reference(REFERENCES[0]))
    assert peer.process is not None
    peer.process.kill()
    with pytest.raises(AssertionError, match=r"^omniORBpy ended with -9 at Reference"):
        peer.ask(Reference(REFERENCES[0]))
    assert peer.ask(Reference(REFERENCES[0]))


@pytest.mark.sampled(2)
@pytest.mark.slow
@settings(DRAWN, max_examples=EXAMPLES)
@given(number=st.integers(0, TYPES * 2), draw=st.randoms(use_true_random=False))
def test_values(types: Types, number: int, draw: random.Random) -> None:
    types.compare(draw, types.compared[number % len(types.compared)])


@pytest.mark.nightly
@settings(DRAWN, max_examples=SMALL_MODULES)
@given(draw=st.randoms(use_true_random=False))
def test_types(
    peer: Peer,
    references: tuple[ObjectReference, ...],
    tmp_path: Path,
    draw: random.Random,
) -> None:
    types = compiled(peer, references, tmp_path, draw, SMALL)
    try:
        for descriptor in types.all:
            types.compare_type_code(descriptor, True)
        for number in range(SMALL_VALUES):
            descriptor = types.compared[number % len(types.compared)]
            types.compare(random.Random(number), descriptor)
    except Exception as error:
        error.add_note(types.text)
        raise
