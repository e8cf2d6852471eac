"""The rules of RtcProfile files: `RTC0530` and on."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NOT_A_PROFILE = Rule(
    "RTC0530",
    "not an RtcProfile",
    Severity.ERROR,
    """\
The root element is not `RtcProfile` of the namespace `http://www.openrtp.org/namespaces/rtc`. A
file whose root is `RtsProfile` describes a system; give that to `rtgen run` or `rtgen graph`.
""",
)
MISSING = Rule(
    "RTC0531",
    "the component has no name",
    Severity.ERROR,
    """\
There is no `rtc:BasicInfo`, or neither it nor the profile's id has the component's name. Attributes
of a profile are namespace-qualified: `rtc:name`, not `name`.
""",
)
LEFT_OUT = Rule(
    "RTC0532",
    "what the schema asks for is left out",
    Severity.WARNING,
    """\
The schema requires the attribute, but the component can be made without it; a usual value is
taken. RTCBuilder may refuse the file.
""",
)
MISSPELT = Rule(
    "RTC0533",
    "misspelt or misplaced attribute",
    Severity.WARNING,
    """\
Templates of format 0.1 misspell some attributes (`rtc:subscriprionType`, `rtcExt:varname` of a
data port, `rtc:varname` of a service interface), and people write attributes without their prefix.
They are read as what is meant.
""",
)
UNKNOWN_WORD = Rule(
    "RTC0534",
    "unknown word",
    Severity.WARNING,
    """\
An attribute that takes one of a few words has another one, such as a `rtc:componentType` other
than `STATIC`, `UNIQUE` and `COMMUTATIVE`. The usual one is taken.
""",
)
BAD_NUMBER = Rule(
    "RTC0535",
    "bad number",
    Severity.WARNING,
    """\
`rtc:executionRate` is a frequency in Hz above zero, `rtc:maxInstances` a whole number. What is
written there is neither; the usual value is taken.
""",
)
BAD_DATE = Rule(
    "RTC0536",
    "bad date",
    Severity.WARNING,
    """\
`rtc:creationDate` and `rtc:updateDate` are dates with a time, `2017-06-21T10:52:15+09:00`; the
zone may be missing. What is written there is none, or has no zone; UTC or 1970 is taken.
""",
)
UNKNOWN_TYPE = Rule(
    "RTC0537",
    "type not found",
    Severity.WARNING,
    """\
The type of a port is declared in none of the IDL files that are known: those among the sources or
on the include path (`-I`), those beside the profile, and the types of OpenRTM. Profiles name the
declaring file by a path of the author's machine, of which the base name alone is looked for.

The port gets an opaque placeholder, so that the component can be made and its other ports used.
A port with a placeholder cannot be connected.
""",
)
WRONG_TYPE = Rule(
    "RTC0538",
    "type is of another kind",
    Severity.WARNING,
    """\
The name of a data port's type stands for something that is no struct or union, or that of a
service interface for something that is no interface. The port gets an opaque placeholder of a
name of its own.
""",
)
PARAMETER_TYPE = Rule(
    "RTC0539",
    "unknown type of a parameter",
    Severity.WARNING,
    """\
Types of parameters are written as C++ has them: `int`, `double`, `std::string`,
`std::vector<double>`. Another word is read as `string`, which holds any value.
""",
)
PARAMETER_VALUE = Rule(
    "RTC0540",
    "default is no value of the parameter's type",
    Severity.WARNING,
    """\
The default of a parameter cannot be read as its type, such as `abc` for an `int`, or lies outside
of its range. OpenRTM reads parameters as text and takes zero for such a value; rtgen leaves the
default out.
""",
)
CONSTRAINT = Rule(
    "RTC0541",
    "constraint that cannot be had",
    Severity.WARNING,
    """\
The constraint of a parameter is one that OpenRTM's text form has no words for (`Not`, `Like`, a
null value, `Or` of ranges), is empty, or contradicts the parameter's type or default, as texts of
templates do. OpenRTM itself does not look at constraints. It is left out.
""",
)
TWICE = Rule(
    "RTC0542",
    "two of one name",
    Severity.WARNING,
    """\
Two data ports of one direction, two interfaces of a service port or two parameters have the same
name. OpenRTM refuses the second one; it is left out.
""",
)
NAME = Rule(
    "RTC0543",
    "name is taken differently",
    Severity.WARNING,
    """\
The component's name is no identifier, is too long, or is that of a type or module, so the component
gets another name; or its vendor, category or version has a colon, a line break or the like, which
would break the id that is made of them. Names of ports, interfaces and
parameters may be any text that can be printed; `_` stands for other characters.
""",
)

SAME_COMPONENT = Rule(
    "RTC0544",
    "component defined twice",
    Severity.ERROR,
    """\
Two definitions, in IDL or as profiles, give the same component. Leave one of them out of the
sources, or rename one.
""",
)
FACTS = Rule(
    "RTC0546",
    "property of rtgen that cannot be used",
    Severity.WARNING,
    """\
A profile that rtgen writes has properties `rtgen.definition` with what its attributes cannot say:
the IDL type of a parameter, bounds, annotations, what the component inherits. One of them was
changed by hand, or speaks of a type that is not found (`-I`). It is passed over; the attributes say
what there is.
""",
)
LOST = Rule(
    "RTC0547",
    "nothing can be made of it",
    Severity.WARNING,
    """\
A port, an interface or a parameter has no name, a port is neither `DataInPort` nor `DataOutPort`
nor `EventPort`, an interface neither `Provided` nor `Required`, or a service port has no interface.
It is left out.
""",
)
BAD_WIDGET = Rule(
    "RTC0548",
    "widget that cannot be had",
    Severity.WARNING,
    """\
The widget of a parameter is none of `text`, `slider.<step>`, `spin`, `radio`, `checkbox` and
`ordered_list`. A text field is taken, as RTSystemEditor does.
""",
)

RULES = (
    NOT_A_PROFILE,
    MISSING,
    LEFT_OUT,
    MISSPELT,
    UNKNOWN_WORD,
    BAD_NUMBER,
    BAD_DATE,
    UNKNOWN_TYPE,
    WRONG_TYPE,
    PARAMETER_TYPE,
    PARAMETER_VALUE,
    CONSTRAINT,
    TWICE,
    NAME,
    SAME_COMPONENT,
    FACTS,
    LOST,
    BAD_WIDGET,
)
