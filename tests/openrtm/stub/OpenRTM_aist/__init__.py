# ruff: noqa: E402
"""A small OpenRTM-aist-Python 2.1 for tests of generated modules.

It behaves over omniORB as OpenRTM does, including its pitfalls, for components, ports,
configuration, contexts, managers and clients of them. omniidl generates the stubs of `RTC`,
`SDOPackage` and `OpenRTM` from the folder `idl` and the data types of `specs/idl`.
"""

# Before any other stub, as OpenRTM does: another package `RTC` ends the import here.
import RTC

assert RTC.RTC_OK is not None

from . import CORBA_RTCUtil, NVUtil
from .buffers import DataPortStatus, RingBuffer
from .contexts import ExtTrigExecutionContext, PeriodicExecutionContext
from .CORBA_RTCUtil import *  # noqa: F403
from .data_ports import InPort, OutPort
from .manager import Delete, Manager
from .naming import CorbaNaming
from .properties import Properties
from .rtobject import DataFlowComponentBase, RTObject_impl
from .service_ports import CorbaConsumer, CorbaPort
from .values import instantiateDataType, setTimestamp, stringTo

__all__ = [
    "CORBA_RTCUtil",
    "CorbaConsumer",
    "CorbaNaming",
    "CorbaPort",
    "DataFlowComponentBase",
    "DataPortStatus",
    "Delete",
    "ExtTrigExecutionContext",
    "InPort",
    "Manager",
    "NVUtil",
    "OutPort",
    "PeriodicExecutionContext",
    "Properties",
    "RTObject_impl",
    "RingBuffer",
    "instantiateDataType",
    "setTimestamp",
    "stringTo",
]
