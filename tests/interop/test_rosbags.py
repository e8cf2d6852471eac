"""Types of ROS 2 compared with rosbags: octets and hashes.

The definitions are those of its store, written as interface files.
"""

from __future__ import annotations

import importlib
import math
import random
import struct
import sys
from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import numpy
import pytest
from msgspec.structs import replace
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from seeds import cases

from rtgen.compiler.backends import Options
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.kit.resources import ros_file, ros_interfaces
from rtgen.compiler.layouts.ros_types import type_hash, type_name
from rtgen.compiler.model import (
    ArrayType,
    Const,
    Model,
    NamedType,
    PrimitiveType,
    SequenceType,
    StringType,
    Struct,
    Type,
)
from rtgen.facts.primitives import FLOAT_LIMITS, INTEGER_RANGES, Primitive
from rtgen.ros2.rosidl import load

pytestmark = pytest.mark.peer

STORE = get_typestore(Stores.ROS2_JAZZY)
MESSAGES = 600
"""Number of messages in each run; `make fuzz` takes 18,000, of all types of the store."""
MAX_ITEMS = 5


def has_char(model: Model, struct: Struct) -> bool:
    return "char" in STORE.generate_msgdef(type_name(struct.name), ros_version=2)[0]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    folder = tmp_path_factory.mktemp("share")
    paths = []
    for name in sorted(STORE.types):
        package, _, message = name.split("/")
        text = STORE.generate_msgdef(name, ros_version=2)[0].partition("=" * 80)[0]
        path = folder / package / "msg" / f"{message}.msg"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        paths.append(path)
    result = load(paths, root=folder)
    assert not result.diagnostics
    return result.model


@pytest.fixture(scope="module")
def package(model: Model, tmp_path_factory: pytest.TempPathFactory) -> ModuleType:
    folder = tmp_path_factory.mktemp("ros")
    emission = BACKEND.emit(model, Options("ros_types", "skeletons", "0.0.0"))
    assert not emission.diagnostics
    for artifact in emission.artifacts:
        path = folder / artifact.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(artifact.text, encoding="utf-8")
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        return importlib.import_module("ros_types")
    finally:
        sys.path.remove(str(folder))


@cache
def module(package: str, name: str) -> ModuleType:
    return importlib.import_module(f"{package}.{name}.msg")


def structs(model: Model) -> list[Struct]:
    return [d for d in model.declarations if isinstance(d, Struct)]


def test_hashes(model: Model) -> None:
    """For rosbags `char` has an identifier of its own; rosidl_adapter makes it uint8."""
    compared = [s for s in structs(model) if not has_char(model, s)]
    assert len(compared) > 150
    for struct_ in compared:
        name = type_name(struct_.name)
        assert (name, type_hash(model, struct_)) == (name, STORE.hash_rihs01(name))


@pytest.fixture(scope="module")
def shipped() -> Model:
    files = [ros_file(name) for name in ros_interfaces()]
    return load(files, root=files[0].parents[2]).model


NEWER_THAN_ROSBAGS = {("nav_msgs", "msg", "Goals")}
"""Messages that later releases of Jazzy have; tests/ros2 compares them with real ones."""


def test_shipped_messages(model: Model, shipped: Model) -> None:
    """Members and constants of each are those of ROS 2, so octets and hashes are, too."""
    compared = [
        s
        for s in shipped.declarations
        if s.name[1] == "msg" and s.name not in NEWER_THAN_ROSBAGS
    ]
    assert len(compared) > 200
    for own in compared:
        theirs = model.find(own.name)
        assert type(own) is type(theirs)
        if isinstance(own, Struct):
            assert isinstance(theirs, Struct)
            assert [(m.name, m.type) for m in own.members] == [
                (m.name, m.type) for m in theirs.members
            ]
            assert type_hash(shipped, own) == type_hash(model, theirs)
        else:
            assert isinstance(own, Const)
            assert isinstance(theirs, Const)
            assert (own.type, own.value) == (theirs.type, theirs.value)
    ours = {s.name for s in compared}
    packages = {name[0] for name in ours}
    assert ours == {d.name for d in model.declarations if d.name[0] in packages}


def test_shipped_services(shipped: Model) -> None:
    """rosbags reads the parts of services as messages."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name in ros_interfaces():
        path = ros_file(name)
        if path.suffix != ".srv":
            continue
        package, _, _ = name.partition("/")
        parts = path.read_text().split("---\n")
        for suffix, part in zip(("Request", "Response"), parts, strict=True):
            full = f"{package}/msg/{path.stem}_{suffix}"
            store.register(get_types_from_msg(part, full))
            own = shipped.find((package, "srv", f"{path.stem}_{suffix}"))
            assert isinstance(own, Struct)
            expected = store.hash_rihs01(full)
            renamed = replace(own, name=(package, "msg", own.name[-1]))
            assert (name, type_hash(shipped, renamed)) == (name, expected)


DTYPES = {
    Primitive.BOOLEAN: numpy.bool_,
    Primitive.OCTET: numpy.uint8,
    Primitive.INT8: numpy.int8,
    Primitive.UINT8: numpy.uint8,
    Primitive.SHORT: numpy.int16,
    Primitive.UNSIGNED_SHORT: numpy.uint16,
    Primitive.LONG: numpy.int32,
    Primitive.UNSIGNED_LONG: numpy.uint32,
    Primitive.LONG_LONG: numpy.int64,
    Primitive.UNSIGNED_LONG_LONG: numpy.uint64,
    Primitive.FLOAT: numpy.float32,
    Primitive.DOUBLE: numpy.float64,
}


class Pair:
    """Makes equal random values for both sides."""

    def __init__(self, model: Model, package: str, draw: random.Random) -> None:
        self.model = model
        self.package = package
        self.draw = draw

    def of(self, type_: Type) -> tuple[Any, Any]:
        if isinstance(type_, NamedType):
            return self.message(self.model.find(type_.name))
        if isinstance(type_, StringType):
            text = "".join(self.draw.choices("abc é漢", k=self.draw.randrange(9)))
            return text, text
        if isinstance(type_, ArrayType):
            return self.many(type_.element, type_.dimensions[0])
        if isinstance(type_, SequenceType):
            most = MAX_ITEMS if type_.bound is None else min(MAX_ITEMS, type_.bound)
            return self.many(type_.element, self.draw.randint(0, most))
        assert isinstance(type_, PrimitiveType)
        value = self.scalar(type_.kind)
        return value, value

    def scalar(self, kind: Primitive) -> Any:
        if kind is Primitive.BOOLEAN:
            return self.draw.random() < 0.5
        if kind in FLOAT_LIMITS:
            number = self.draw.choice((self.draw.gauss(0, 1e6), 0.0, math.inf))
            return struct.unpack("<f", struct.pack("<f", number))[0]
        low, high = INTEGER_RANGES[kind]
        if kind is Primitive.OCTET:
            # For rosbags a byte is signed.
            high = 127
        return self.draw.choice((low, high, self.draw.randint(low, high)))

    def many(self, element: Type, count: int) -> tuple[Any, Any]:
        pairs = [self.of(element) for _ in range(count)]
        ours, theirs = [a for a, _ in pairs], [b for _, b in pairs]
        if isinstance(element, PrimitiveType):
            octets = element.kind in (Primitive.OCTET, Primitive.UINT8)
            array: Any = numpy.array(theirs, dtype=DTYPES[element.kind])
            return (bytes(ours) if octets else ours), array
        return ours, theirs

    def message(self, declaration: Any) -> tuple[Any, Any]:
        assert isinstance(declaration, Struct)
        pairs = {m.name: self.of(m.type) for m in declaration.members}
        name = declaration.name
        cls = getattr(module(self.package, name[0]), name[2])
        their_cls: Callable[..., Any] = STORE.types[type_name(name)]
        ours = cls(*(a for a, _ in pairs.values()))
        return ours, their_cls(**{key: b for key, (_, b) in pairs.items()})


@pytest.mark.nightly
@pytest.mark.random
def test_octets_of_random_messages(model: Model, package: ModuleType) -> None:
    chosen = structs(model)
    for case in cases(MESSAGES):
        draw = random.Random(case)
        declaration = chosen[case % len(chosen)]
        ours, theirs = Pair(model, package.__name__, draw).message(declaration)
        name = type_name(declaration.name)
        for little in (True, False):
            header = bytes((0, little, 0, 0))
            octets = header + ours.to_cdr(little)
            expected = bytes(STORE.serialize_cdr(theirs, name, little_endian=little))
            # rosbags pads the end to four octets.
            assert octets == expected[: len(octets)], (case, name)
            assert not any(expected[len(octets) :]), (case, name)
            assert type(ours).from_cdr(expected[4 : len(octets)], little) == ours
            back = STORE.deserialize_cdr(octets, name)
            assert STORE.serialize_cdr(back, name, little_endian=little) == expected
