"""The rules about components: what can be emitted, with the story `rtgen explain` tells."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

_NAMES = """\
The name of a component becomes the name of a Python class, of a folder and of files. So it has to
be an IDL identifier: a letter, then letters, digits and underscores, at most 120 of them.
"""

_SAME_MODULE = """\
A component `LineFollower` stands in the package `components/line_follower`. Two components whose
names give the same package would overwrite each other:

```idl
component LineFollower { };
component Line_Follower { };     // line_follower, too
```

Rename one of them.
"""

_VERSION = """\
The version is a part of the profile's id and is compared by tools: usually numbers with dots
between them, such as `1.2.0`. It has no blanks and no colon.
"""

_DATE = """\
`created` and `updated` are of the type xsd:dateTime: `2025-02-11T10:30:00+00:00`. The fraction of
a second and the zone may be missing. Both come from the definition, so that the same input always
gives the same files.
"""

_CHOICE = """\
An RtcProfile knows these words alone: the activity is `PERIODIC`, `SPORADIC` or `EVENTDRIVEN`, the
component type `STATIC`, `UNIQUE` or `COMMUTATIVE`.
"""

_ID_PART = """\
Vendor, category, name and version make up the profile's id, `RTC:vendor:category:name:version`.
A colon or a line break within one of them would make the id ambiguous.
"""

_NUMBER = """\
The rate is in Hz and above zero. `max_instances` is zero (any number of instances) or above.
"""

_TEXT = """\
XML 1.0 cannot hold control characters other than tab and line feed, nor lone surrogates, in
whatever notation. A name, a unit, a default or a comment that has one cannot go into `RTC.xml`.
"""

_SHADOWS = """\
Without a package for them, skeletons are modules at the top level, and there a component's module
can hide one of Python's own: `Queue` becomes `src/queue.py`, and with `src` on the path whatever
imports `queue` of the standard library gets the component instead.

```toml
[output]
skeletons = "src"            # src/queue.py hides the module queue
skeletons = "src/mynodes"    # src/mynodes/queue.py hides nothing
```

Give the skeletons a package, or rename the component.
"""

_SAME_PORT = """\
Ports are told apart by direction and outside name. Two OutPorts, or two InPorts, of one name
cannot be connected one by one:

```idl
component C {
    publishes T a;
    @name("a") publishes T b;    // RTC0201
};
```

An InPort and an OutPort may have the same outside name.
"""

_DATA_TYPE = """\
A data port carries a struct or a union (or a typedef of one), by habit one whose first member is
the time stamp `RTC::Time tm`. Put a bare number or sequence into a struct.
"""

_INTERFACE = """\
`provides` and `uses` name an interface that is not local, since it is called through a port.
"""

_SAME_INTERFACE = """\
A provider and a consumer meet by interface type and instance name. Within one service port two
providers (or two consumers) need different instance names: `@instance("left")`.
"""

_SAME_PARAMETER = """\
Configuration parameters are set by their outside name, which must be unique in the component.
"""

_PARAMETER_TYPE = """\
The value of a parameter travels as text, so its type is an enum, or one of these, or a sequence
of one of these: `boolean`, `string`, `wstring`, `octet`, `int8`, `short`, `long`, `long long` and
their unsigned twins, `float`, `double`.
"""

_DEFAULT_TYPE = """\
The default has to be a value of the parameter's type: within the range of the integer, one of the
enumerators, not longer than the bound. The default of a sequence is a text with commas:

```idl
@default("0.1, 0.2") attribute sequence<double> gains;
```
"""

_DEFAULT_RANGE = """\
The default has to meet the parameter's own `@min`, `@max` and `@constraint`. Without `@default` the
default is the zero value of the type, and that has to meet them, too.
"""

_BOUNDS = """\
`@min` and `@max` belong to numbers (and sequences of numbers), fit their type, and `@min` is not
above `@max`.
"""

_CONSTRAINT = """\
A constraint is a comparison with `x`, an interval, an enumeration, one value, a list with one
constraint for each item, or a hash:

| text | meaning |
|---|---|
| `x>=5`, `5<=x` | bounded at one end |
| `0<=x<=10`, `0<x<10` | bounded at both ends |
| `(a,b,c)` | one of these |
| `100` | only this |
| `x<1,x>=2` | first item, second item |
| `{k1:0<x<1,k2:x>=3}` | by key |
"""

_WIDGET = """\
The widgets that RTSystemEditor knows: `text`, `slider.<step>` (`slider.0.05`), `spin`, `radio`,
`checkbox`, `ordered_list`.
"""

_WIDGET_NEEDS = """\
A slider or spin box needs a lower and an upper bound (`@min` and `@max`, `@range`, or a
constraint such as `0<=x<=10`); radio buttons, check boxes and ordered lists need an enumeration
(`(a,b,c)`, or an enum as type). Without it RTSystemEditor falls back to a text field.
"""

NAME = Rule("RTC0101", "component name cannot be used", Severity.ERROR, _NAMES)
SAME_MODULE = Rule(
    "RTC0102", "two components with one package", Severity.ERROR, _SAME_MODULE
)
VERSION = Rule("RTC0103", "version cannot be used", Severity.ERROR, _VERSION)
DATE = Rule("RTC0104", "date is no xsd:dateTime", Severity.ERROR, _DATE)
CHOICE = Rule("RTC0105", "unknown activity or component type", Severity.ERROR, _CHOICE)
ID_PART = Rule("RTC0106", "text would break the profile's id", Severity.ERROR, _ID_PART)
NUMBER = Rule("RTC0107", "bad rate or number of instances", Severity.ERROR, _NUMBER)
TEXT = Rule("RTC0108", "text that XML cannot hold", Severity.ERROR, _TEXT)
SHADOWS = Rule(
    "RTC0109", "skeleton that hides a module of Python", Severity.WARNING, _SHADOWS
)
SAME_PORT = Rule(
    "RTC0201", "two ports of one direction and name", Severity.ERROR, _SAME_PORT
)
DATA_TYPE = Rule(
    "RTC0202", "data port without a struct or union", Severity.ERROR, _DATA_TYPE
)
INTERFACE = Rule(
    "RTC0203", "service port without an interface", Severity.ERROR, _INTERFACE
)
SAME_INTERFACE = Rule(
    "RTC0204", "interface twice in a port", Severity.ERROR, _SAME_INTERFACE
)
SAME_PARAMETER = Rule(
    "RTC0301", "two parameters of one name", Severity.ERROR, _SAME_PARAMETER
)
PARAMETER_TYPE = Rule(
    "RTC0302", "type cannot be a parameter", Severity.ERROR, _PARAMETER_TYPE
)
DEFAULT_TYPE = Rule(
    "RTC0303", "default does not fit the type", Severity.ERROR, _DEFAULT_TYPE
)
DEFAULT_RANGE = Rule(
    "RTC0304", "default is not allowed", Severity.ERROR, _DEFAULT_RANGE
)
BOUNDS = Rule("RTC0305", "bad bounds", Severity.ERROR, _BOUNDS)
CONSTRAINT = Rule("RTC0306", "constraint cannot be read", Severity.ERROR, _CONSTRAINT)
WIDGET = Rule("RTC0307", "unknown widget", Severity.ERROR, _WIDGET)
WIDGET_NEEDS = Rule(
    "RTC0308", "widget without bounds or values", Severity.WARNING, _WIDGET_NEEDS
)

RULES = (
    NAME,
    SAME_MODULE,
    VERSION,
    DATE,
    CHOICE,
    ID_PART,
    NUMBER,
    TEXT,
    SHADOWS,
    SAME_PORT,
    DATA_TYPE,
    INTERFACE,
    SAME_INTERFACE,
    SAME_PARAMETER,
    PARAMETER_TYPE,
    DEFAULT_TYPE,
    DEFAULT_RANGE,
    BOUNDS,
    CONSTRAINT,
    WIDGET,
    WIDGET_NEEDS,
)
