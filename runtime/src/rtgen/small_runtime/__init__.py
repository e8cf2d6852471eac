"""The small runtime: components, ports and codecs for boards, compatible with MicroPython.

Behaviours run unchanged on the embedded runtime, since names, callbacks and the life cycle are the
same. All buffers have a fixed size and are allocated when a system is set up; there are no threads.
Only modules that MicroPython has are imported.
"""

from .codes import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    OUT_OF_RESOURCES,
    PORT_OK,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    SECOND,
    UNSUPPORTED,
    PortStatus,
    ReturnCode_t,
)
from .components import Component
from .ports import InPort, OutPort
from .sequences import (
    Numbers,
    SizeError,
    Values,
    bounded,
    copy_array,
    copy_items,
    exactly,
)
from .system import System
from .wire import CodecError, Wire, from_cdr, to_cdr

__all__ = [
    "ACTIVE_STATE",
    "BAD_PARAMETER",
    "CREATED_STATE",
    "ERROR_STATE",
    "INACTIVE_STATE",
    "OUT_OF_RESOURCES",
    "PORT_OK",
    "PRECONDITION_NOT_MET",
    "RTC_ERROR",
    "RTC_OK",
    "SECOND",
    "UNSUPPORTED",
    "CodecError",
    "Component",
    "InPort",
    "Numbers",
    "OutPort",
    "PortStatus",
    "ReturnCode_t",
    "SizeError",
    "System",
    "Values",
    "Wire",
    "bounded",
    "copy_array",
    "copy_items",
    "exactly",
    "from_cdr",
    "to_cdr",
]
