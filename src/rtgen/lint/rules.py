"""The rules of `rtgen lint` (LINT...): warnings for what is likely wrong, notes for habits."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNUSED_INCLUDE = Rule(
    "LINT0001",
    "unused include",
    Severity.WARNING,
    """
The file includes another one, but names nothing that comes with it. Each include makes a file
depend on more than it needs.

```idl
#include "camera.idl"                 // nothing of it is used: remove the line
struct Wheel { double radius; };
```

A file without declarations of its own, which only gathers others, is left alone.
""",
)

UNUSED_TYPEDEF = Rule(
    "LINT0002",
    "unused typedef",
    Severity.NOTE,
    """
The typedef's name stands nowhere else in the files that were read. Remove it, unless it is part of
what others use.

```idl
typedef sequence<double> Angles;      // not used
struct Arm { sequence<double> angle; };
```
""",
)

ANONYMOUS_TYPE = Rule(
    "LINT0003",
    "anonymous type",
    Severity.NOTE,
    """
A member's sequence, array or map has no name of its own. CORBA 3 deprecates that (OMG CORBA 3.0,
3.11.6): no other declaration can use the same type, and some languages get a made-up name.

```idl
struct Arm { sequence<double> angle; };                            // anonymous
typedef sequence<double> Angles;  struct Leg { Angles angle; };    // named
```
""",
)

NAMING = Rule(
    "LINT0004",
    "inconsistent name",
    Severity.WARNING,
    """
Most names of this kind (types, members, operations, attributes, constants, enumerators) in the file
are in one style, and this one is in another. Names that fit several styles count for none.

```idl
struct WheelSpeed { double left; };
struct WheelLoad { double left; };
struct wheel_torque { double left; };   // the odd one
struct WheelAngle { double left; };
```
""",
)

UNDOCUMENTED = Rule(
    "LINT0005",
    "no comment",
    Severity.NOTE,
    """
A type, interface, operation or component has no doc comment, so the generated classes and
profiles have no description. Only checked on demand: `--select LINT0005`.

```idl
/** The pose of the robot in the map. */
struct Pose { double x; double y; };
```
""",
)

NO_PREFIX = Rule(
    "LINT0006",
    "repository id without prefix",
    Severity.NOTE,
    """
Repository ids tell interfaces apart in a running system. Without `#pragma prefix` another project's
interface of the same name has the same id.

```idl
#pragma prefix "example.org"
interface Gripper { void open(); };     // IDL:example.org/Gripper:1.0
```
""",
)

ANY_IN_PORT = Rule(
    "LINT0007",
    "any in the data of a port",
    Severity.WARNING,
    """
The data of a port holds an `any`, so a connection cannot be checked: the two ends may mean
different things. Write the type, or a union of the possible ones.

```idl
struct Command { any value; };                     // anything may come
component Driver { consumes Command command; };
```
""",
)

NO_TIME = Rule(
    "LINT0008",
    "data of a port without a time",
    Severity.WARNING,
    """
Data of RT components begins with a time stamp, `Time tm` (OpenRTM, BasicDataType.idl). Without it
a receiver cannot tell how old the data is, and tools that log or play back data cannot order it.

```idl
struct TimedPose { RTC::Time tm; double x; double y; };
component Localizer { publishes TimedPose pose; };
```
""",
)

UNBOUNDED = Rule(
    "LINT0009",
    "no bound",
    Severity.WARNING,
    """
A member holds a sequence, map or string without a bound, so the size of the data has no limit.
Where memory is fixed, each of them needs one. Only checked on demand: `--select LINT0009`.

```idl
struct Scan { sequence<float> ranges; };           // any number
struct Scan2 { sequence<float, 1081> ranges; };    // at most so many
```
""",
)

MISSING_ENUMERATORS = Rule(
    "LINT0010",
    "enumerators without a branch",
    Severity.WARNING,
    """
A union over an enum has no branch for some enumerators and no default. That is allowed, and a
union with such a discriminator holds nothing, but mostly an enumerator was added later and the
branch forgotten.

```idl
enum Kind { NONE, POINT, LINE };
union Shape switch (Kind) { case POINT: double x; };   // NONE, LINE?
```
""",
)

PYTHON_NAME = Rule(
    "LINT0011",
    "name that differs in Python",
    Severity.NOTE,
    """
The name is a keyword of Python, a name that every generated class has, or one of Python's own
functions and types. A clash is resolved by a trailing underscore, which a reader of the definition
has to know.

```idl
struct Message { string from; };        // from_ in Python
```
""",
)

NO_HEARTBEAT = Rule(
    "LINT0012",
    "device without heartbeat",
    Severity.WARNING,
    """
The description of a CANopen device has no object 1017h (producer heartbeat time). A manager or a
proxy then hears of the node only at its boot-up, and does not notice when it is gone: node guarding
is not supported, and CiA 301 advises against it.

```ini
[1017]
ParameterName=Producer heartbeat time
ObjectType=0x7
DataType=0x0006
AccessType=rw
DefaultValue=1000
```
""",
)

NO_VENDOR = Rule(
    "LINT0013",
    "device that does not tell its vendor",
    Severity.WARNING,
    """
Neither `[DeviceInfo]` nor object 1018h sub-index 1 tells a vendor number, or it is 0. A manager
compares it with the node's before it configures the node; without it, any device with that node-id
is taken for the right one.

```ini
[DeviceInfo]
VendorNumber=0x0000009A
```
""",
)

SAME_NAME = Rule(
    "LINT0014",
    "objects of one name",
    Severity.NOTE,
    """
Several objects of a CANopen device have the same name, or names that differ in case or special
characters only. In IDL, in Python and in commands each of them then bears its index and sub-index:

```ini
[6401sub1]
ParameterName=Input                     ; Input_6401_01
[6401sub2]
ParameterName=Input                     ; Input_6401_02
```

Objects below 2000h, where that is usual, are left out.
""",
)

RULES: tuple[Rule, ...] = (
    UNUSED_INCLUDE,
    UNUSED_TYPEDEF,
    ANONYMOUS_TYPE,
    NAMING,
    UNDOCUMENTED,
    NO_PREFIX,
    ANY_IN_PORT,
    NO_TIME,
    UNBOUNDED,
    MISSING_ENUMERATORS,
    PYTHON_NAME,
    NO_HEARTBEAT,
    NO_VENDOR,
    SAME_NAME,
)

ON_DEMAND: tuple[Rule, ...] = (UNDOCUMENTED, UNBOUNDED)
"""Rules that only run if selected."""
