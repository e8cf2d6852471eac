"""Calls of `OpaqueRpc` as the octets of GIOP bodies (CORBA 3.3 part 2, 9.4)."""

from __future__ import annotations

from typing import Final

from rtgen.runtime import idl
from rtgen.runtime.opaque_rpc.interface import OCTETS, OpaqueRpc, OpaqueRpcFailed
from rtgen.runtime.services.call_types import CallTypes

_CALLS: Final[dict[str, dict[str, CallTypes]]] = {
    OpaqueRpc._descriptor_.repository_id: {
        "begin": CallTypes(
            request={"request": OCTETS, "first": idl.UNSIGNED_LONG},
            reply={"_result": OCTETS},
            raises=(OpaqueRpcFailed,),
        ),
        "more": CallTypes(
            request={"count": idl.UNSIGNED_LONG},
            reply={"_result": OCTETS},
            raises=(OpaqueRpcFailed,),
        ),
        "end": CallTypes(),
        "reset": CallTypes(),
    }
}
