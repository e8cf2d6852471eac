"""The rules of OpenRTM-aist-Python modules that are read: `RTC0550` and on."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNREADABLE = Rule(
    "RTC0550",
    "not a module of Python",
    Severity.ERROR,
    """\
The file cannot be opened, or is not a module of Python. Components of OpenRTM-aist 1.x are often
written for Python 2 (`print "..."`): `pip install 'rtgen[python2]'` brings a converter, with which
they are read as they are. Nothing in the file is executed.
""",
)
NO_COMPONENT = Rule(
    "RTC0551",
    "no component",
    Severity.ERROR,
    """\
A component of OpenRTM-aist-Python is a list of texts with an `implementation_id` (the module spec)
and a class that derives from `OpenRTM_aist.DataFlowComponentBase`. One of them is missing.
""",
)
COMPUTED = Rule(
    "RTC0552",
    "is worked out when the module runs",
    Severity.WARNING,
    """\
A name, a type or a value is the outcome of a computation that only running the module settles: an
argument, a file that is read, a parameter. The module is only read, never executed. Loops over
constants, formatted texts, methods and base classes of the same repository are followed. Add the
rest to the definition by hand.
""",
)
NOT_ADDED = Rule(
    "RTC0553",
    "port that is never added",
    Severity.WARNING,
    """\
The port is made, but no `addInPort`, `addOutPort` or `addPort` is there for it, so the running
component does not have it. It is left out.
""",
)
NOT_CARRIED = Rule(
    "RTC0554",
    "has no place in a definition",
    Severity.WARNING,
    """\
The module spec has an entry that a component definition has no place for: further configuration
sets (they belong into the component's `.conf` file or the system file), properties of the
execution context or of the manager.
""",
)
BEHAVIOUR = Rule(
    "RTC0555",
    "behaviour to be moved by hand",
    Severity.NOTE,
    """\
A definition has ports, services and parameters. The bodies of the callbacks stay in the old module;
move them into the skeleton that `rtgen generate` creates.
""",
)

ASSUMED = Rule(
    "RTC0556",
    "module that is not read as it stands",
    Severity.WARNING,
    """\
The file is not in the encoding that it declares (UTF-8 if it declares none), or is written for
Python 2. It was read all the same: check texts with other letters than English ones.
""",
)

RULES = (
    UNREADABLE,
    NO_COMPONENT,
    COMPUTED,
    NOT_ADDED,
    NOT_CARRIED,
    BEHAVIOUR,
    ASSUMED,
)
