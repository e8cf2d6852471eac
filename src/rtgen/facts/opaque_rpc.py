"""The communication RTC of TECS boards: its names, parameters and defaults (RTM-TECS, 5.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

FIRST_PORT: Final = 8931
"""The TCP port of the first join, as tecsgen has it."""

TIMEOUT: Final = 1.0
"""How long a call may take [s], where nothing else is said."""

LONGEST_TIMEOUT: Final = 1e6
"""The greatest time-out [s]."""

COMPONENT: Final = "OpaqueRpcCommunication"
"""The type of the component."""

DESCRIPTION: Final = "Carries requests of any signature to a TECS board"
CATEGORY: Final = "TECS"
VENDOR: Final = "rtgen"
RATE: Final = 10.0
"""Cycles a second [Hz]."""

PORT: Final = "service"
"""The service port; its one interface is `OpaqueRpc`."""

INSTANCE: Final = "communication"
"""The instance name of the interface."""

PORT_DESCRIPTION: Final = "The channel, for one marshaller."


@dataclass(frozen=True, slots=True)
class CommunicationParameter:
    """A configuration parameter; `constraint` is written as in RTC.xml."""

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
