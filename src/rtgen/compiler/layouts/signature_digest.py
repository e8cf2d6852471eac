"""Digest of a TECS signature, by which two peers detect that their signatures differ.

OpaqueRPC sends neither names nor types, so peers with different signatures would misread each
other. `signature_text` contains all that determines the bytes and their meaning; `RTCPlugin.rb`
writes the same text from tecsgen's model (`templates/tecs/RTCPlugin.rb.j2`), so both must be
changed together. docs/opaque-rpc.md describes it.
"""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import sha256

from rtgen.compiler.layouts.tdr import references
from rtgen.compiler.layouts.tdr_messages import is_error_code
from rtgen.compiler.model.c_types import (
    CArrayType,
    CEnumType,
    CFunctionType,
    CPointerType,
    CScalarType,
    CStructType,
    CType,
    DescriptorType,
    Expression,
    Literal,
    resolve,
)
from rtgen.compiler.model.tecs import (
    Signature,
    Sizes,
    TecsFunction,
    TecsUnit,
)
from rtgen.compiler.model.types import ScopedName
from rtgen.facts.tdr import Scalar

DIGITS = 16
"""Hexadecimal digits of a digest: the first 64 bits of SHA-256."""

SPELLINGS = {
    **{kind.value: kind for kind in Scalar if kind.value.endswith("_t")},
    "size_t": Scalar.ULONG,
    "char": Scalar.CHAR,
    "signed char": Scalar.SCHAR,
    "unsigned char": Scalar.UCHAR,
    "signed short": Scalar.SHORT,
    "signed int": Scalar.INT,
    "signed long": Scalar.LONG,
    "signed long long": Scalar.LONG_LONG,
    "float": Scalar.FLOAT32,
    "double": Scalar.DOUBLE64,
}
"""Basic types of CDL by their spellings in tecsgen, and as typedefs of C headers."""


def signature_digest(unit: TecsUnit, signature: Signature) -> str:
    """Return the digest of a signature, in lower-case hexadecimal digits."""
    text = signature_text(unit, signature)
    return sha256(text.encode()).hexdigest()[:DIGITS]


def signature_text(unit: TecsUnit, signature: Signature) -> str:
    """Return the input of the digest: one line for each function."""
    writer = _Writer(unit)
    return "".join(f"{writer.function(f)}\n" for f in signature.functions)


class _Writer:
    """Writes types without typedefs, qualifiers and tags; a struct's members at its first use."""

    def __init__(self, unit: TecsUnit) -> None:
        self._unit = unit
        self._numbers: dict[ScopedName, int] = {}

    def function(self, function: TecsFunction) -> str:
        oneway = "oneway " if function.oneway else ""
        error = "error " if is_error_code(function.returns) else ""
        returns = self._type(function.returns)
        parameters = ",".join(
            f"{p.direction} {self._type(p.type)} {p.name}{_sizes(p.sizes)}"
            for p in function.parameters
        )
        return f"{function.id} {oneway}{error}{returns} {function.name}({parameters})"

    def _type(self, type_: CType) -> str:
        match resolve(type_):
            case CScalarType(kind=kind):
                return kind.value
            case CPointerType(target=target):
                return f"*{self._type(target)}"
            case CArrayType(element=element, size=size):
                return f"[{'' if size is None else size}]{self._type(element)}"
            case CStructType(tag=tag):
                return self._struct(tag)
            case CEnumType():
                return "enum"
            case CFunctionType():
                return "function"
            case DescriptorType():
                return "descriptor"
        raise AssertionError(type_)

    def _struct(self, tag: ScopedName) -> str:
        earlier = self._numbers.get(tag)
        if earlier is not None:
            return f"struct {earlier}"
        number = self._numbers[tag] = len(self._numbers) + 1
        struct = self._unit.structs.get(tag)
        if struct is None:
            return f"struct {number}"
        members = "".join(
            f"{self._type(m.type)} {m.name}{_sizes(m.sizes)};" for m in struct.members
        )
        return f"struct {number}{{{members}}}"


def _sizes(sizes: Sizes) -> str:
    return "".join(f" {text}" for text in _specifiers(sizes))


def _specifiers(sizes: Sizes) -> Iterator[str]:
    if sizes.size_is is not None:
        yield f"size_is={_length(sizes.size_is)}"
    if sizes.max_size is not None:
        yield f"max={sizes.max_size}"
    if sizes.count_is is not None:
        yield f"count_is={_length(sizes.count_is)}"
    if sizes.is_string:
        yield f"string={_length(sizes.string)}"
    if sizes.nullable:
        yield "nullable"


def _length(expression: Expression | None) -> str:
    """Return the constant length, or the parameters in its expression; empty without a length."""
    if isinstance(expression, Literal):
        value = expression.value
        return str(int(value) if isinstance(value, bool | float) else value)
    return "+".join(dict.fromkeys(references(expression)))
