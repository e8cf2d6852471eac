"""The rules of what a project has no ROS 2 interface or name for."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_IN_ROS = Rule("ROS0120", "declaration that ROS 2 cannot express", Severity.WARNING)
SAME_SERVICE = Rule(
    "ROS0121", "function of a board without a name in ROS 2", Severity.WARNING
)

RULES = rules_of(globals())
