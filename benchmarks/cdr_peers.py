"""Types and values of cyclonedds-python, protobuf and omniORBpy, from rtgen's descriptors."""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import new_class
from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    EnumDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)

SPECS = Path(__file__).resolve().parents[1] / "specs" / "idl"
OWN = Path(__file__).with_name("cdr_types.idl")


class CycloneDds:
    """Classes of cyclonedds-python."""

    def __init__(self) -> None:
        self._made: dict[str, Any] = {}

    def type(self, descriptor: Any) -> Any:
        """Return the type for a descriptor."""
        from cyclonedds.idl import types

        match plain(descriptor):
            case PrimitiveDescriptor(name):
                names = {
                    "double": "float64",
                    "octet": "uint8",
                    "unsigned long": "uint32",
                }
                return getattr(types, names.get(name, "int32"))
            case StringDescriptor():
                return str
            case SequenceDescriptor(element):
                return types.sequence[self.type(element)]
            case found if found.name not in self._made:
                self._made[found.name] = self._declared(found)
        return self._made[plain(descriptor).name]

    def _declared(self, descriptor: Any) -> Any:
        from cyclonedds.idl import IdlEnum, IdlStruct, IdlUnion, types

        name = descriptor.name.rpartition("::")[2]
        scoped = {"typename": descriptor.name.replace("::", ".")}
        match descriptor:
            case EnumDescriptor(members=members):
                return new_class(
                    name, (IdlEnum,), scoped, lambda body: body.update(members)
                )
            case StructDescriptor(members=members):
                own = {m.attribute: self.type(m.type) for m in members}
                parts = {"__annotations__": own, "__module__": __name__}
                return dataclass(type(name, (IdlStruct,), parts, **scoped))
        own = {}
        for branch in descriptor.branches:
            inner = self.type(branch.type)
            labels = list(branch.labels)
            if isinstance(plain(descriptor.switch), EnumDescriptor):
                labels = [self.type(descriptor.switch)(int(n)) for n in labels]
            own[branch.attribute] = (
                types.default[inner] if branch.default else types.case[labels, inner]
            )
        switch = {"discriminator": self.type(descriptor.switch)}
        parts = {"__annotations__": own, "__module__": __name__}
        keywords = {**switch, **scoped}
        return new_class(name, (IdlUnion,), keywords, lambda body: body.update(parts))

    def value(self, descriptor: Any, value: Any) -> Any:
        """Return the value as an instance of its type."""
        match plain(descriptor):
            case StructDescriptor(members=members):
                parts = [
                    self.value(m.type, getattr(value, m.attribute)) for m in members
                ]
                return self.type(descriptor)(*parts)
            case UnionDescriptor() as union:
                branch = union.branch(value.discriminator)
                assert branch is not None
                inner = self.value(branch.type, value.value)
                if branch.default:
                    return self.type(union)(
                        discriminator=value.discriminator, value=inner
                    )
                return self.type(union)(**{branch.attribute: inner})
            case SequenceDescriptor(element) if not isinstance(value, bytes):
                return [self.value(element, item) for item in value]
            case EnumDescriptor() as enum:
                return self.type(enum)(int(value))
        return value


class Protobuf:
    """Messages of protobuf, in one file."""

    def __init__(self, descriptors: list[Any]) -> None:
        from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
        from google.protobuf.internal import api_implementation

        self.name = f"protobuf ({api_implementation.Type()})"
        self._kinds = descriptor_pb2.FieldDescriptorProto
        self._file = descriptor_pb2.FileDescriptorProto(
            name="b.proto", package="b", syntax="proto3"
        )
        self._done: set[str] = set()
        for descriptor in descriptors:
            self._message(descriptor)
        pool = descriptor_pool.DescriptorPool()
        pool.Add(self._file)
        found = message_factory.GetMessageClassesForFiles(["b.proto"], pool)
        self.classes = {name.removeprefix("b."): made for name, made in found.items()}

    def _message(self, descriptor: Any) -> None:
        name = descriptor.name.replace("::", "_")
        if name in self._done:
            return
        self._done.add(name)
        entries = getattr(descriptor, "members", None) or descriptor.branches
        fields = [(each.attribute, *self._kind(each.type)) for each in entries]
        message = self._file.message_type.add(name=name)
        choice = isinstance(descriptor, UnionDescriptor)
        if choice:
            message.oneof_decl.add(name="choice")
        for number, (field, kind, type_name, repeated) in enumerate(fields, 1):
            label = (
                self._kinds.LABEL_REPEATED if repeated else self._kinds.LABEL_OPTIONAL
            )
            added = message.field.add(name=field, number=number, type=kind, label=label)
            if type_name:
                added.type_name = type_name
            if choice:
                added.oneof_index = 0

    def _kind(self, type_: Any) -> tuple[int, str, bool]:
        kinds = self._kinds
        match plain(type_):
            case PrimitiveDescriptor(name):
                found = {"double": kinds.TYPE_DOUBLE, "long": kinds.TYPE_INT32}
                return found.get(name, kinds.TYPE_FIXED32), "", False
            case StringDescriptor():
                return kinds.TYPE_STRING, "", False
            case SequenceDescriptor(element):
                return *self._kind(element)[:2], True
            case found:
                self._message(found)
                return kinds.TYPE_MESSAGE, f".b.{found.name.replace('::', '_')}", False


@dataclass
class Texts:
    """Source texts that build a value, and that read all its fields: `made`."""

    constants: dict[str, Any]

    def ours(self, descriptor: Any, value: Any) -> str:
        """Return the expression that builds a value of rtgen's type."""
        match plain(descriptor):
            case StructDescriptor(members=members):
                parts = (
                    self.ours(m.type, getattr(value, m.attribute)) for m in members
                )
            case UnionDescriptor() as union:
                branch = union.branch(value.discriminator)
                assert branch is not None
                switch = self._constant(value.discriminator)
                parts = iter((switch, self.ours(branch.type, value.value)))
            case _:
                return self._constant(value)
        return f"{self._constant(type(value))}({', '.join(parts)})"

    def theirs(self, descriptor: Any, value: Any, classes: dict[str, Any]) -> str:
        """Return the expression that builds a message of protobuf."""
        found = plain(descriptor)
        match found:
            case StructDescriptor(members=members):
                pairs = [
                    (m.attribute, m.type, getattr(value, m.attribute)) for m in members
                ]
            case UnionDescriptor() as union:
                branch = union.branch(value.discriminator)
                assert branch is not None
                pairs = [(branch.attribute, branch.type, value.value)]
            case _:
                return self._constant(value)
        parts = (f"{n}={self.theirs(t, v, classes)}" for n, t, v in pairs)
        made = self._constant(classes[found.name.replace("::", "_")])
        return f"{made}({', '.join(parts)})"

    def read(self, descriptor: Any, value: Any, place: str, theirs: bool) -> list[str]:
        """Return the expressions of all scalars of a value, in order."""
        match plain(descriptor):
            case StructDescriptor(members=members):
                pairs = [
                    (m.attribute, m.type, getattr(value, m.attribute)) for m in members
                ]
            case UnionDescriptor() as union:
                branch = union.branch(value.discriminator)
                assert branch is not None
                name = branch.attribute if theirs else "value"
                pairs = [(name, branch.type, value.value)]
            case SequenceDescriptor():
                return [f"list({place})"]
            case _:
                return [place]
        return [
            text
            for name, type_, inner in pairs
            for text in self.read(type_, inner, f"{place}.{name}", theirs)
        ]

    def _constant(self, value: Any) -> str:
        name = f"c{len(self.constants)}"
        self.constants[name] = value
        return name

    def function(self, arguments: str, expression: str) -> Callable[..., Any]:
        """Return a function that evaluates an expression."""
        text = f"lambda {arguments}: {expression}"
        function: Callable[..., Any] = eval(text, self.constants)
        return function


def load_omniorb(folder: Path, idl: Path) -> None:
    """Generate and import omniORBpy's stubs of an IDL file and its includes."""
    import importlib

    from omniORB import CORBA

    scripts = sysconfig.get_path("scripts")
    omniidl = shutil.which("omniidl", path=scripts) or "omniidl"
    options = ["-bpython", "-Wbinline", f"-I{SPECS}", f"-C{folder}"]
    subprocess.run([omniidl, *options, str(idl)], check=True)
    CORBA.ORB_init(["bench", "-ORBnativeCharCodeSet", "UTF-8"])
    sys.path.insert(0, str(folder))
    importlib.import_module(f"{idl.stem}_idl")


def omniorb_type(descriptor: Any) -> Any:
    """Return omniORBpy's type code."""
    import omniORB

    return omniORB.findTypeCode(descriptor.repository_id)


def omniorb_value(descriptor: Any, value: Any) -> Any:
    """Return the value as an object of omniORBpy."""
    import omniORB

    found = plain(descriptor)
    match found:
        case StructDescriptor(members=members):
            parts = [
                omniorb_value(m.type, getattr(value, m.attribute)) for m in members
            ]
            return omniORB.findType(found.repository_id)[1](*parts)
        case UnionDescriptor():
            branch = found.branch(value.discriminator)
            assert branch is not None
            switch = omniorb_value(found.switch, value.discriminator)
            inner = omniorb_value(branch.type, value.value)
            return omniORB.findType(found.repository_id)[1](switch, inner)
        case SequenceDescriptor(element) if not isinstance(value, bytes):
            return [omniorb_value(element, item) for item in value]
        case EnumDescriptor():
            return omniORB.findType(found.repository_id)[3][int(value)]
    return value
