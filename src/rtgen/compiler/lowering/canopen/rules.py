"""The rules of lowering CANopen devices (EDS0800 to EDS0807, except EDS0805)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity

SAME_MODULE = Rule("EDS0800", "two devices of one name", Severity.ERROR)
TAKEN_MODULE = Rule("EDS0801", "name that a device cannot have", Severity.ERROR)
NO_PORT = Rule("EDS0802", "PDO without a port", Severity.WARNING)
BAD_PARAMETER = Rule("EDS0803", "object that cannot be a parameter", Severity.ERROR)
NO_DEFAULT = Rule("EDS0804", "parameter without a default", Severity.WARNING)
TAKEN_NAME = Rule(
    "EDS0806", "declaration of a device that exists already", Severity.ERROR
)

MISSING_TYPE = Rule(
    "EDS0807",
    "type of OpenRTM or CANopen missing in the project's own file",
    Severity.ERROR,
)

RULES = (
    *(SAME_MODULE, TAKEN_MODULE, NO_PORT, BAD_PARAMETER, NO_DEFAULT),
    *(TAKEN_NAME, MISSING_TYPE),
)
