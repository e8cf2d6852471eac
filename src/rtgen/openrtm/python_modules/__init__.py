"""Reads modules of OpenRTM-aist-Python (rtc-template, RTCBuilder) without executing them."""

from typing import TYPE_CHECKING

from rtgen.compiler.kit.deferred import deferred

if TYPE_CHECKING:
    from rtgen.openrtm.python_modules.component import ModuleResult, read

__all__ = ["ModuleResult", "read"]

# Its rules do not need it.
__getattr__ = deferred("rtgen.openrtm.python_modules.component", __all__)
