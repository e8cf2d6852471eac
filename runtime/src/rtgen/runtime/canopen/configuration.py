"""The configuration that all CANopen proxies, and all devices, have."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rtgen.facts.canopen_parameters import OF_DEVICES, OF_PROXIES, SharedParameter
from rtgen.runtime.rtc.declarations import Configuration, parameter


def _declared(parameters: Iterable[SharedParameter]) -> dict[str, Any]:
    return {
        each.name: parameter(
            each.default,
            each.description,
            unit=each.unit,
            minimum=each.minimum,
            maximum=each.maximum,
        )
        for each in parameters
    }


_PROXY = _declared(OF_PROXIES)
_DEVICE = _declared(OF_DEVICES)


class ProxyConfiguration(Configuration):
    """Parameters of every proxy."""

    interface: str = _PROXY["interface"]
    channel: str = _PROXY["channel"]
    bitrate: int = _PROXY["bitrate"]
    options: str = _PROXY["options"]
    node_id: int = _PROXY["node_id"]
    network: str = _PROXY["network"]
    master: bool = _PROXY["master"]
    heartbeat_timeout: int = _PROXY["heartbeat_timeout"]
    boot_timeout: int = _PROXY["boot_timeout"]
    emergency_stop: str = _PROXY["emergency_stop"]
    recoveries: int = _PROXY["recoveries"]
    sdo_in_error: bool = _PROXY["sdo_in_error"]


class DeviceConfiguration(Configuration):
    """Parameters of every device."""

    interface: str = _DEVICE["interface"]
    channel: str = _DEVICE["channel"]
    bitrate: int = _DEVICE["bitrate"]
    options: str = _DEVICE["options"]
    node_id: int = _DEVICE["node_id"]
    network: str = _DEVICE["network"]
    merged_stop: bool = _DEVICE["merged_stop"]
    parameter_file: str = _DEVICE["parameter_file"]
