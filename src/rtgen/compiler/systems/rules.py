"""The rules of running a system (codes SYS...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

TIMELINE_FILE = "timeline.toml"
"""The timeline beside a system, which its runs follow by default."""

UNKNOWN_TYPE = Rule("SYS0001", "component type without a factory", Severity.ERROR)
NO_COMPONENT = Rule("SYS0002", "factory that makes no component", Severity.ERROR)
CONNECTION = Rule("SYS0003", "ports that cannot be joined", Severity.ERROR)
PARAMETER = Rule(
    "SYS0004", "configuration that a component does not take", Severity.ERROR
)
UNKNOWN_INSTANCE = Rule("SYS0005", "unknown instance", Severity.ERROR)
CONDITION = Rule("SYS0006", "no such condition", Severity.ERROR)
TIMELINE = Rule("SYS0007", "timeline that cannot be followed", Severity.ERROR)
OBSERVABLE = Rule("SYS0008", "unknown observable", Severity.ERROR)
ELSEWHERE = Rule("SYS0009", "component of another process", Severity.ERROR)
MEASURE = Rule("SYS0010", "measure that cannot be taken", Severity.ERROR)
TOLERANCE = Rule("SYS0012", "tolerance that cannot be applied", Severity.ERROR)
RAISED = Rule("SYS0021", "code of a component failed", Severity.ERROR)
IMPORT = Rule(
    "SYS0022", "module of a component that cannot be imported", Severity.ERROR
)
BLOCKED = Rule("SYS0023", "code of a component that does not return", Severity.WARNING)
NOTICE = Rule("SYS0024", "notice of the runtime", Severity.WARNING)
ROS_TOPIC = Rule("SYS0025", "port that cannot be a topic of ROS 2", Severity.ERROR)
FOREIGN = Rule("SYS0026", "foreign component out of reach", Severity.ERROR)
SKIPPED = Rule("SYS0027", "event of a timeline that is skipped", Severity.WARNING)
MISSING = Rule("SYS0028", "samples that could not be written", Severity.ERROR)
SYSTEM_PROPERTY = Rule("SYS0029", "unknown property of a system", Severity.ERROR)
CALL = Rule("SYS0030", "call of a timeline that failed", Severity.ERROR)
SKELETON = Rule("SYS0031", "behaviour that does nothing", Severity.WARNING)
TOPIC_QOS = Rule(
    "SYS0032",
    "QoS of a topic that has no effect, or lets nothing through",
    Severity.WARNING,
)
RECORDING = Rule("SYS0033", "recording that cannot be read", Severity.ERROR)
UNREAD = Rule("SYS0034", "recording that is not whole", Severity.WARNING)
NO_TOPIC = Rule("SYS0035", "topic that a bag lacks", Severity.WARNING)

RULES = rules_of(globals())
