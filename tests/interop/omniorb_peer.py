"""A process with omniORBpy: values arrive as octets, become its own, and return as octets.

omniORBpy can abort; then this process ends, not the tests. `Peer` is the side of the tests; run as
a program, this file is the other one. Both find the generated package and omniidl's module in the
same folders.
"""

from __future__ import annotations

import importlib
import os
import pickle
import subprocess
import sys
import traceback
from array import array
from contextlib import suppress
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any

from rtgen.runtime.marshalling.descriptors import (
    AliasDescriptor,
    ArrayDescriptor,
    BoxDescriptor,
    EnumDescriptor,
    ExceptionDescriptor,
    FixedDescriptor,
    InterfaceDescriptor,
    LinkDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StringDescriptor,
    StructDescriptor,
    UnionDescriptor,
    plain,
)
from rtgen.runtime.marshalling.dynamic.reader import Reader
from rtgen.runtime.marshalling.dynamic.values import decoded, encoded
from rtgen.runtime.marshalling.dynamic.writer import Output, Writer
from rtgen.runtime.marshalling.octets import ObjectReference

COMMAND = ["rtgen", "-ORBnativeCharCodeSet", "UTF-8"]
TYPE_CODE = PrimitiveDescriptor("CORBA::TypeCode")


@dataclass(frozen=True)
class Load:
    """Request to import rtgen's package and omniidl's module, each from its folder."""

    ours: str
    package: str
    theirs: str
    module: str


@dataclass(frozen=True)
class Convert:
    """Request for the octets of a value, constructed from its type and rtgen's octets.

    The answer is a pair: omniORB's octets of the value, and (if `reads`) those of the value that it
    decoded from rtgen's octets.
    """

    repository_id: str
    octets: bytes
    little_endian: bool
    reads: bool


@dataclass(frozen=True)
class Code:
    """Request for the octets of a type code."""

    repository_id: str
    little_endian: bool


@dataclass(frozen=True)
class Reference:
    """Request for the octets of an object reference that is given as text."""

    text: str


@dataclass(frozen=True)
class Failed:
    """The error of a request."""

    text: str


def octets_of(descriptor: Any, value: Any, little_endian: bool) -> bytes:
    """Return the body of a value; omniORBpy puts an exception's repository id in front."""
    if not isinstance(descriptor, ExceptionDescriptor):
        return encoded(descriptor, value, little_endian)
    out = Output()
    writer = Writer(out, little_endian)
    writer.value(StringDescriptor(), descriptor.repository_id)
    writer.value(descriptor, value)
    return bytes(out)


def value_of(descriptor: Any, octets: bytes, little_endian: bool) -> Any:
    """Return the value of such a body."""
    if not isinstance(descriptor, ExceptionDescriptor):
        return decoded(descriptor, octets, little_endian)
    reader = Reader(octets, little_endian)
    assert reader.value(StringDescriptor()) == descriptor.repository_id
    value = reader.value(descriptor)
    reader.end()
    return value


class Peer:
    """The process. `ask` raises AssertionError if omniORBpy raises or ends."""

    def __init__(self) -> None:
        self._loaded: list[Load] = []
        self.process: subprocess.Popen[bytes] | None = None

    def load(self, load: Load) -> None:
        """Make types known."""
        self.ask(load)
        self._loaded.append(load)

    def ask(self, request: Any) -> Any:
        """Return the answer to a request."""
        if self.process is None:
            self.process = _start()
            for load in self._loaded:
                self._exchange(load)
        return self._exchange(request)

    def _exchange(self, request: Any) -> Any:
        process = self.process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            pickle.dump(request, process.stdin)
            process.stdin.flush()
            answer = pickle.load(process.stdout)
        except (EOFError, BrokenPipeError):
            self.close()
            message = f"omniORBpy ended with {process.returncode} at {request}"
            raise AssertionError(message) from None
        if isinstance(answer, Failed):
            raise AssertionError(f"omniORBpy, at {request}:\n{answer.text}")
        return answer

    def close(self) -> None:
        """End the process."""
        process, self.process = self.process, None
        if process is not None:
            assert process.stdin is not None
            assert process.stdout is not None
            with suppress(BrokenPipeError):
                process.stdin.close()
            process.wait()
            process.stdout.close()


def _start() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )


class Converter:
    """Converts rtgen's values to omniORBpy's."""

    def __init__(self) -> None:
        self.omniorb = importlib.import_module("omniORB")
        self.corba = importlib.import_module("omniORB.CORBA")
        self.orb = self.corba.ORB_init(COMMAND)
        self.types: dict[str, Any] = {}

    def answer(self, request: Any) -> Any:
        """Return the answer to a request."""
        match request:
            case Load():
                return self.load(request)
            case Convert():
                return self.convert(request)
            case Code(repository_id, little_endian):
                code = self.type_code(self.types[repository_id])
                return self.omniorb.cdrMarshal(
                    self.corba._tc_TypeCode, code, int(little_endian)
                )
            case Reference(text):
                made = self.orb.string_to_object(text)
                return self.omniorb.cdrMarshal(self.corba._tc_Object, made, 1)
        raise TypeError(request)

    def load(self, load: Load) -> None:
        """Import both packages."""
        sys.path[:0] = [load.ours, load.theirs]
        try:
            importlib.invalidate_caches()
            inner = Path(load.ours, load.package, "_idl").glob("[a-z]*.py")
            for file in sorted(inner):
                found = importlib.import_module(f"{load.package}._idl.{file.stem}")
                for type_ in vars(found).values():
                    made = getattr(type_, "_descriptor_", None)
                    if isinstance(type_, type) and made is not None:
                        self.types[getattr(made, "repository_id", "")] = made
            importlib.import_module(load.module)
        finally:
            del sys.path[:2]

    def convert(self, request: Convert) -> tuple[bytes, bytes | None]:
        """Return omniORB's octets of a value, and of the value that it decodes."""
        descriptor = self.types[request.repository_id]
        order = int(request.little_endian)
        value = value_of(descriptor, request.octets, request.little_endian)
        code = self.type_code(descriptor)
        written = self.omniorb.cdrMarshal(
            code, self.converted(descriptor, value, {}), order
        )
        if not request.reads:
            return written, None
        read = self.omniorb.cdrUnmarshal(code, request.octets, order)
        return written, self.omniorb.cdrMarshal(code, read, order)

    def type_code(self, descriptor: Any) -> Any:
        """Return omniORB's type code for a descriptor."""
        match descriptor:
            case PrimitiveDescriptor(name):
                short = name.removeprefix("CORBA::").replace("unsigned ", "u")
                return getattr(self.corba, "_tc_" + short.replace(" ", ""))
            case StringDescriptor(wide, bound):
                make = self.orb.create_wstring_tc if wide else self.orb.create_string_tc
                return make(bound or 0)
            case SequenceDescriptor(element, bound):
                return self.orb.create_sequence_tc(bound or 0, self.type_code(element))
            case ArrayDescriptor(element, dimensions):
                made = self.type_code(element)
                for length in reversed(dimensions):
                    made = self.orb.create_array_tc(length, made)
                return made
            case FixedDescriptor(digits, scale):
                return self.orb.create_fixed_tc(digits, scale)
        return self._named(descriptor, "_tc_")

    def converted(self, descriptor: Any, value: Any, memo: dict[int, Any]) -> Any:
        """Return omniORB's value; shared parts stay shared."""
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
            case SequenceDescriptor() | ArrayDescriptor() if isinstance(value, array):
                return value.tolist()
            case SequenceDescriptor(AliasDescriptor()) | ArrayDescriptor(
                AliasDescriptor(), (_,)
            ) if not isinstance(value, list):
                # omniORBpy accepts texts and octets only if no typedef names the element.
                return list(value)
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
            case PrimitiveDescriptor("Object") | InterfaceDescriptor() if value:
                return self._reference(value)
        return value

    def _reference(self, value: ObjectReference) -> Any:
        body = encoded(PrimitiveDescriptor("Object"), value, True)
        ior = b"\x01\0\0\0" + body
        return self.orb.string_to_object(f"IOR:{ior.hex()}")

    def _class(self, descriptor: Any) -> Any:
        return self._named(descriptor, "")

    def _named(self, descriptor: Any, prefix: str) -> Any:
        # A decoded type code has no scopes in its name.
        known = self.types[descriptor.repository_id]
        module, *scopes, name = known.name.split("::")
        return reduce(getattr, [*scopes, prefix + name], sys.modules[module])


def main() -> None:
    """Answer requests from standard input until it ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    converter = Converter()
    while True:
        try:
            request = pickle.load(sys.stdin.buffer)
        except EOFError:
            break
        try:
            answer = converter.answer(request)
        except Exception:
            answer = Failed(traceback.format_exc())
        pickle.dump(answer, answers)
        answers.flush()
    converter.orb.destroy()


if __name__ == "__main__":
    # By its name, so that requests and answers have the classes of the tests.
    importlib.import_module(Path(__file__).stem).main()
