"""Runtime of modules and systems generated for OpenRTM-aist-Python.

A behaviour runs there unchanged: its life cycle, ports, configuration and services are those of the
embedded runtime, driven by OpenRTM. OpenRTM is only imported when used; the conversions (`wire`)
and the connection of systems require omniORBpy.
"""

from __future__ import annotations

from rtgen.runtime.openrtm.host import Host
from rtgen.runtime.openrtm.starting import (
    behaviour_module,
    instance_arguments,
    main,
)

__all__ = ["Host", "behaviour_module", "instance_arguments", "main"]
