"""Calls of `OpaqueRpc` as the octets of GIOP bodies (CORBA 3.3 part 2, 9.4), which is XCDR1."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Final, Self

from rtgen.runtime.calls import Call
from rtgen.runtime.cdr import Aggregated, Buffer
from rtgen.runtime.descriptors import (
    MemberDescriptor,
    PrimitiveDescriptor,
    StringDescriptor,
    StructDescriptor,
)
from rtgen.runtime.opaque_rpc.interface import OCTETS, OpaqueRpc, OpaqueRpcFailed

_NUMBER: Final = PrimitiveDescriptor("unsigned long")


class _Body(Aggregated):
    """A body that is marshalled by its descriptor."""

    __slots__ = ()

    def to_cdr(self, little_endian: bool = True) -> bytes:
        """The value as a CDR body; raises CdrError."""
        return self.to_xcdr1(little_endian)

    @classmethod
    def from_cdr(cls, data: Buffer, little_endian: bool = True) -> Self:
        """The value of a CDR body; raises CdrError."""
        return cls.from_xcdr1(data, little_endian)


@dataclass(slots=True)
class _BeginRequest(_Body):
    """Arguments of `OpaqueRpc::begin`."""

    _descriptor_: ClassVar[StructDescriptor] = StructDescriptor(
        "",
        "OpaqueRpc.begin request",
        (MemberDescriptor("request", OCTETS), MemberDescriptor("first", _NUMBER)),
    )

    request: bytes = b""
    first: int = 0

    def _snapshot_(self) -> _BeginRequest:
        return replace(self)


@dataclass(slots=True)
class _MoreRequest(_Body):
    """Arguments of `OpaqueRpc::more`."""

    _descriptor_: ClassVar[StructDescriptor] = StructDescriptor(
        "", "OpaqueRpc.more request", (MemberDescriptor("count", _NUMBER),)
    )

    count: int = 0

    def _snapshot_(self) -> _MoreRequest:
        return replace(self)


@dataclass(slots=True)
class _OctetsReply(_Body):
    """Results of `OpaqueRpc::begin` and `OpaqueRpc::more`."""

    _descriptor_: ClassVar[StructDescriptor] = StructDescriptor(
        "", "OpaqueRpc octets reply", (MemberDescriptor("_result", OCTETS),)
    )

    _result: bytes = b""

    def _snapshot_(self) -> _OctetsReply:
        return replace(self)


@dataclass(slots=True)
class _FailedReply(_Body):
    """The reply that represents the exception `OpaqueRpc::Failed`."""

    _descriptor_: ClassVar[StructDescriptor] = StructDescriptor(
        "IDL:OpaqueRpc/Failed:1.0",
        "OpaqueRpc.Failed raised",
        (
            MemberDescriptor("_id", StringDescriptor()),
            *OpaqueRpcFailed._descriptor_.members,
        ),
    )

    _id: str = ""
    code: int = 0
    reason: str = ""

    def _snapshot_(self) -> _FailedReply:
        return replace(self)


_RAISES = ((_FailedReply, OpaqueRpcFailed),)
_CALLS: Final[dict[str, dict[str, Call]]] = {
    OpaqueRpc._descriptor_.repository_id: {
        "begin": Call(request=_BeginRequest, reply=_OctetsReply, raises=_RAISES),
        "more": Call(request=_MoreRequest, reply=_OctetsReply, raises=_RAISES),
        "end": Call(),
        "reset": Call(),
    }
}
