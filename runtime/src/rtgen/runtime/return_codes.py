"""Return codes, states and kinds of OMG RTC 1.0 (`RTC.idl`), and the status of a port operation."""

from enum import IntEnum


class ReturnCode_t(IntEnum):
    """Return code of life cycle operations (OMG RTC 1.0, 5.2.2.1)."""

    RTC_OK = 0
    RTC_ERROR = 1
    BAD_PARAMETER = 2
    UNSUPPORTED = 3
    OUT_OF_RESOURCES = 4
    PRECONDITION_NOT_MET = 5


class LifeCycleState(IntEnum):
    """State of a component in one execution context (OMG RTC 1.0, 5.2.2.3)."""

    CREATED_STATE = 0
    INACTIVE_STATE = 1
    ACTIVE_STATE = 2
    ERROR_STATE = 3


class ExecutionKind(IntEnum):
    """Kind of an execution context: the source of its ticks (OMG RTC 1.0, 5.2.2.7)."""

    PERIODIC = 0
    EVENT_DRIVEN = 1
    OTHER = 2


class PortStatus(IntEnum):
    """Outcome of a `write`: six of OpenRTM's `DataPort.idl`, two for no connection."""

    PORT_OK = 0
    PORT_ERROR = 1
    BUFFER_FULL = 2
    BUFFER_EMPTY = 3
    BUFFER_TIMEOUT = 4
    UNKNOWN_ERROR = 5
    PRECONDITION_NOT_MET = 6
    """The port has no connection; the sample was not sent."""
    CONNECTION_LOST = 7
    """The connection was removed while the writer waited for room."""


RTC_OK = ReturnCode_t.RTC_OK
RTC_ERROR = ReturnCode_t.RTC_ERROR
BAD_PARAMETER = ReturnCode_t.BAD_PARAMETER
UNSUPPORTED = ReturnCode_t.UNSUPPORTED
OUT_OF_RESOURCES = ReturnCode_t.OUT_OF_RESOURCES
PRECONDITION_NOT_MET = ReturnCode_t.PRECONDITION_NOT_MET

CREATED_STATE = LifeCycleState.CREATED_STATE
INACTIVE_STATE = LifeCycleState.INACTIVE_STATE
ACTIVE_STATE = LifeCycleState.ACTIVE_STATE
ERROR_STATE = LifeCycleState.ERROR_STATE

PORT_OK = PortStatus.PORT_OK
