"""Calls of `OpaqueRpc` as the octets of GIOP bodies (CORBA 3.3 part 2, 9.4)."""

from __future__ import annotations

from typing import ClassVar, Final

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated
from rtgen.runtime.opaque_rpc.interface import OCTETS, OpaqueRpc, OpaqueRpcFailed
from rtgen.runtime.services.calls import Call


class _BeginRequest(Aggregated):
    """Arguments of `OpaqueRpc::begin`."""

    _descriptor_: ClassVar = idl.struct(
        "OpaqueRpc.begin request",
        idl.traits(repository_id=""),
        request=OCTETS,
        first=idl.UNSIGNED_LONG,
    )

    request: bytes = b""
    first: int = 0


class _MoreRequest(Aggregated):
    """Arguments of `OpaqueRpc::more`."""

    _descriptor_: ClassVar = idl.struct(
        "OpaqueRpc.more request",
        idl.traits(repository_id=""),
        count=idl.UNSIGNED_LONG,
    )

    count: int = 0


class _OctetsReply(Aggregated):
    """Results of `OpaqueRpc::begin` and `OpaqueRpc::more`."""

    _descriptor_: ClassVar = idl.struct(
        "OpaqueRpc octets reply", idl.traits(repository_id=""), _result=OCTETS
    )

    _result: bytes = b""


class _FailedReply(Aggregated):
    """The reply that raises `OpaqueRpc::Failed`."""

    _descriptor_: ClassVar = idl.struct(
        "OpaqueRpc.Failed raised",
        idl.traits(repository_id="IDL:OpaqueRpc/Failed:1.0"),
        _id=idl.STRING,
        code=idl.LONG,
        reason=idl.STRING,
    )

    _id: str = ""
    code: int = 0
    reason: str = ""


_RAISES = ((_FailedReply, OpaqueRpcFailed),)
_CALLS: Final[dict[str, dict[str, Call]]] = {
    OpaqueRpc._descriptor_.repository_id: {
        "begin": Call(request=_BeginRequest, reply=_OctetsReply, raises=_RAISES),
        "more": Call(request=_MoreRequest, reply=_OctetsReply, raises=_RAISES),
        "end": Call(),
        "reset": Call(),
    }
}
