"""Communication RTC of TECS boards: names, parameters and defaults (RTM-TECS, 5.2)."""

from __future__ import annotations

from typing import Final

import msgspec

FIRST_PORT: Final = 8931
"""The TCP port of the first join, as in tecsgen."""

TIMEOUT: Final = 1.0
"""Default time-out of a call [s]."""

MAX_TIMEOUT: Final = 1e6
"""Maximum time-out [s]."""

COMPONENT: Final = "OpaqueRpcCommunication"
"""The type of the component."""

DESCRIPTION: Final = "Carries requests of any signature to a TECS board"
CATEGORY: Final = "TECS"
VENDOR: Final = "rtgen"
RATE: Final = 10.0
"""Cycles a second [Hz]."""

PORT: Final = "service"
"""The service port, whose only interface is `OpaqueRpc`."""

INSTANCE: Final = "communication"
"""The instance name of the interface."""

PORT_DESCRIPTION: Final = "The channel, for one marshaller."


class CommunicationParameter(msgspec.Struct, frozen=True, gc=False):
    """A configuration parameter; `constraint` has the text form of RTC.xml."""

    name: str
    default: str | float
    description: str
    unit: str = ""
    constraint: str = ""


PARAMETERS: Final = (
    CommunicationParameter(
        "type", "TCP", "`TCP`, or `SERIA` (`SERIAL`) for a serial line."
    ),
    CommunicationParameter("ipaddr", "127.0.0.1", "TCP: the board's address."),
    CommunicationParameter(
        "port",
        str(FIRST_PORT),
        "TCP: the board's port; serial line: its device.",
    ),
    CommunicationParameter("baudrate", "none", "Serial line: its speed in bit/s."),
    CommunicationParameter(
        "tap", "none", "TCP: the local address or network interface to use."
    ),
    CommunicationParameter(
        "timeout", TIMEOUT, "How long a call may take.", "s", "x>0.0"
    ),
)
"""The parameters of the component, in order."""
