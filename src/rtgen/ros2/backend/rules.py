"""The rule of ROS 2 interface files that cannot be written."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

NOT_IN_ROS = Rule("ROS0120", "declaration that ROS 2 cannot express", Severity.WARNING)

RULES = rules_of(globals())
