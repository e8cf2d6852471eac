"""Facts and configuration parameters that all CANopen proxies, and all devices, have."""

from __future__ import annotations

from typing import Final, NamedTuple


class SharedParameter(NamedTuple):
    """A parameter; bool, int and str are IDL's boolean, long and string."""

    name: str
    default: bool | int | str
    description: str
    unit: str = ""
    minimum: int | None = None
    maximum: int | None = None


COMPONENT_FACTS: Final = {
    "category": "CANopen",
    "vendor": "rtgen",
    "rate": 100.0,
    "max_instances": 0,
}
"""Members of their profiles."""

MAX_NODE_ID: Final = 127
LSS: Final = 255
"""The node-id of a device that waits for LSS to assign one."""

_BUS: Final = (
    SharedParameter(
        "interface",
        "virtual",
        "Interface of python-can; in simulated time the bus is simulated.",
    ),
    SharedParameter("channel", "can0", "Channel of the interface."),
    SharedParameter(
        "bitrate", 0, "Bit rate; 0: the default of the interface.", "bit/s", 0
    ),
    SharedParameter(
        "options",
        "",
        'Further arguments of the interface, such as "host=127.0.0.1,port=29536".',
    ),
)
_NETWORK: Final = SharedParameter(
    "network", "", "Network: name of its bus file; empty: none."
)

OF_PROXIES: Final = (
    *_BUS,
    SharedParameter("node_id", 1, "Node-id.", "", 1, MAX_NODE_ID),
    _NETWORK,
    SharedParameter(
        "master",
        False,
        "Whether the proxy itself sends NMT commands if the process has no manager on the bus.",
    ),
    SharedParameter(
        "heartbeat_timeout",
        0,
        "Heartbeat time-out; 0: the value of the network, else three periods.",
        "ms",
        0,
    ),
    SharedParameter(
        "boot_timeout",
        2000,
        "Maximum time from a reset to the boot-up message.",
        "ms",
        1,
    ),
    SharedParameter(
        "emergency_stop",
        "",
        "Emergency codes that lead to ERROR, such as xxxx,-82xx; others are only reported. "
        "Empty: the value of the network.",
    ),
    SharedParameter(
        "recoveries",
        0,
        "Maximum number of automatic recoveries from ERROR in a row; 0: the value of the network.",
        "",
        0,
    ),
    SharedParameter(
        "sdo_in_error",
        False,
        "Whether the device is pre-operational in ERROR, so that SDO works, instead of stopped.",
    ),
)

OF_DEVICES: Final = (
    *_BUS,
    SharedParameter("node_id", 1, f"Node-id, {LSS}: assigned by LSS.", "", 1, LSS),
    _NETWORK,
    SharedParameter(
        "merged_stop",
        False,
        "Whether a stop command has the effect of figure 111 of RTC-CANopen.",
    ),
    SharedParameter(
        "parameter_file",
        "",
        "File of stored parameters (1010h), name.json below the working folder; empty: none.",
    ),
)

PROXY_CONFIGURATION: Final = "rtgen.runtime.canopen.configuration:ProxyConfiguration"
DEVICE_CONFIGURATION: Final = "rtgen.runtime.canopen.configuration:DeviceConfiguration"
SHARED: Final = {PROXY_CONFIGURATION: OF_PROXIES, DEVICE_CONFIGURATION: OF_DEVICES}
"""The parameters of the runtime's classes, by module and name."""
