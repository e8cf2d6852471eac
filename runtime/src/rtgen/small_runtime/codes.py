# mypy: allow-untyped-defs, allow-incomplete-defs, allow-untyped-calls
"""Return codes, states and units."""

SECOND = 1_000_000_000

RTC_OK = 0
RTC_ERROR = 1
BAD_PARAMETER = 2
UNSUPPORTED = 3
OUT_OF_RESOURCES = 4
PRECONDITION_NOT_MET = 5
ReturnCode_t = int

CREATED_STATE = 0
INACTIVE_STATE = 1
ACTIVE_STATE = 2
ERROR_STATE = 3

ACTIVATE = 1
DEACTIVATE = 2
RESET = 3
CODE_NAMES = (
    "RTC_OK",
    "RTC_ERROR",
    "BAD_PARAMETER",
    "UNSUPPORTED",
    "OUT_OF_RESOURCES",
    "PRECONDITION_NOT_MET",
)


class PortStatus:
    """The results of `OutPort.write`."""

    PORT_OK = 0
    PRECONDITION_NOT_MET = 5


PORT_OK = PortStatus.PORT_OK
