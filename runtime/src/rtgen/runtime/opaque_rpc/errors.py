"""Error codes of TECS OpaqueRPC, the kernel's and two of its own, and the exceptions with them.

A code returned by a function may be composite: a main code in the low 8 bits, a sub code above.
"""

from __future__ import annotations

from typing import Final

from rtgen.runtime.services.servants import ServiceError

E_OK: Final = 0
E_SYS: Final = -5
E_PAR: Final = -17
"""A size is negative or exceeds its maximum."""
E_ID: Final = -18
"""There is no function with that id."""
E_NOMEM: Final = -33
"""A message needs more memory than is available."""
E_OBJ: Final = -41
"""The channel fails in a way that has no code of its own."""
E_NOEXS: Final = -42
E_TMOUT: Final = -50
"""The peer did not respond in time."""
E_CLS: Final = -52
E_WBLK: Final = -57
E_BOVR: Final = -58
"""The stream ended before the message did."""
E_RPC: Final = -68
"""The call failed in transit; the sub code gives the reason."""
E_RESET: Final = -101
E_MAGIC: Final = -102
"""A message has a wrong start or end."""


def ERCD(main: int, sub: int) -> int:
    """Return the composite of a main and a sub code, as a C int."""
    return (sub << 8) | (main & 0xFF)


def MERCD(code: int) -> int:
    """Return the main code: the low 8 bits, signed."""
    return ((code & 0xFF) ^ 0x80) - 0x80


def SERCD(code: int) -> int:
    """Return the sub code; -1 for a code that is not composite and negative."""
    return code >> 8


class RpcError(ServiceError):
    """A call failed in transit. Service ports pass it on.

    `sub` is the reason's code (`E_MAGIC`, `E_TMOUT`, ...); `code` is `ERCD(E_RPC, sub)`, the result
    of a function of type `ER` or `ER_INT`.
    """

    def __init__(self, sub: int, reason: str) -> None:
        super().__init__(sub, reason)
        self.sub = sub
        self.reason = reason

    @property
    def code(self) -> int:
        """The composite error code."""
        return ERCD(E_RPC, MERCD(self.sub))

    def __str__(self) -> str:
        name = _NAMES.get(self.sub, str(self.sub))
        return f"{self.reason} ({name})"


class ProtocolError(RpcError):
    """The received bytes are not a message of the signature, or exceed a limit."""


class ChannelError(RpcError):
    """The channel cannot send or receive: refused, closed, interrupted, timed out."""


class ArgumentError(ValueError):
    """A value cannot be sent: out of the type's range, of another length, or NULL."""


_NAMES = {
    value: name
    for name, value in list(globals().items())
    if name.startswith("E_") and isinstance(value, int)
}


def described(code: int) -> str:
    """Return an error code by name: `E_PAR (-17)`, `E_RPC, E_TMOUT (-12612)`."""
    codes = (code,) if code >= -128 else (MERCD(code), MERCD(SERCD(code)))
    names = ", ".join(_NAMES.get(each, str(each)) for each in codes)
    return names if names == str(code) else f"{names} ({code})"
