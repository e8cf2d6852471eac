"""The interface `OpaqueRpc` of a communication RTC, as in `OpaqueRpc.idl` in this folder."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final, TypeAlias

from rtgen.runtime import idl
from rtgen.runtime.cdr import UserException
from rtgen.runtime.marshalling.descriptors import InterfaceDescriptor
from rtgen.runtime.services.servants import Servant, Skeleton, Stub, operation

IDL: Final = Path(__file__).with_name("OpaqueRpc.idl")
"""The definition of the interface."""

OCTETS: Final = idl.alias("OpaqueRpc::Octets", idl.sequence(idl.OCTET))
"""The typedef `OpaqueRpc::Octets`."""


@dataclass(eq=False)
class OpaqueRpcFailed(UserException):
    """The channel failed; `code` is the kernel's, such as `E_TMOUT`."""

    _descriptor_: ClassVar = idl.exception(
        "OpaqueRpc::Failed", code=idl.LONG, reason=idl.STRING
    )

    code: int = 0
    reason: str = ""


class OpaqueRpc(Servant):
    """A channel to a TECS board, for one call at a time."""

    _descriptor_: ClassVar[InterfaceDescriptor] = InterfaceDescriptor(
        "IDL:OpaqueRpc:1.0",
        "OpaqueRpc",
        (
            "OpaqueRpc::Octets begin(in OpaqueRpc::Octets request, in unsigned long first)"
            " raises (OpaqueRpc::Failed)",
            "OpaqueRpc::Octets more(in unsigned long count) raises (OpaqueRpc::Failed)",
            "void end()",
            "void reset()",
        ),
        (),
    )
    _calls_: ClassVar[str] = ".interface_calls"
    Octets: TypeAlias = bytes
    Failed: TypeAlias = OpaqueRpcFailed

    @abstractmethod
    @operation(raises=(OpaqueRpcFailed,))
    def begin(self, request: bytes, first: int) -> bytes:
        """Allocate the channel and send a request; return the first octets of the reply.

        The channel is free again if it fails.
        """

    @abstractmethod
    @operation(raises=(OpaqueRpcFailed,))
    def more(self, count: int) -> bytes:
        """Return the next octets of the reply."""

    @abstractmethod
    def end(self) -> None:
        """Free the channel after the reply was read."""

    @abstractmethod
    def reset(self) -> None:
        """Free the channel after a failed call, and drop its reply."""


class OpaqueRpcStub(OpaqueRpc, Stub):
    """Calls a servant of `OpaqueRpc` through an invoker."""


class OpaqueRpcSkeleton(Skeleton, interface=OpaqueRpc):
    """Calls a servant of `OpaqueRpc` by operation name."""
