"""What generated modules and systems for OpenRTM-aist-Python share.

A behaviour runs there as it is: its life cycle, ports, configuration and services are those of the
embedded runtime, driven and fed by OpenRTM's. Nothing imports OpenRTM before it is used; the
conversions (`wire`) and what connects systems need omniORBpy.
"""

from __future__ import annotations

from rtgen.runtime.openrtm.host import Host
from rtgen.runtime.openrtm.starting import instance_arguments, main

__all__ = ["Host", "instance_arguments", "main"]
