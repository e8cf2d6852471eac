"""Rules of ROS 2 interface files (ROS01xx)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

MISSING_FILE = Rule("ROS0100", "interface file does not exist", Severity.ERROR)
UNREADABLE = Rule("ROS0101", "interface file cannot be read", Severity.ERROR)
SYNTAX = Rule("ROS0102", "line that is neither field nor constant", Severity.ERROR)
BAD_NAME = Rule("ROS0103", "name that ROS 2 does not allow", Severity.ERROR)
BAD_TYPE = Rule("ROS0104", "type that cannot be written so", Severity.ERROR)
UNKNOWN_TYPE = Rule("ROS0105", "message type that is not found", Severity.ERROR)
BAD_VALUE = Rule("ROS0106", "value that does not fit its type", Severity.ERROR)
DUPLICATE = Rule("ROS0107", "name given twice", Severity.ERROR)
SECTIONS = Rule("ROS0108", "wrong number of parts", Severity.ERROR)
RECURSIVE = Rule("ROS0109", "message that contains itself", Severity.ERROR)
TOO_MANY = Rule("ROS0110", "too many findings", Severity.ERROR)
OPEN_QUOTE = Rule("ROS0111", "text with a quote that is not closed", Severity.WARNING)

RULES = rules_of(globals())
