"""The rules of the target openrtm: `RTC0560` to `RTC0589`."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

RENAMED = Rule(
    "RTC0560",
    "port has another name in OpenRTM",
    Severity.WARNING,
    """
An OpenRTM component cannot have two ports of one name, of whatever kind; OMG's components can. The
InPort keeps its name. An OutPort that is called the same is registered as `<name>_out`, a service
port as `<name>_service`. Connections there have to use this name, as the emitted system files do.

```idl
component Relay {
    consumes T data;
    @name("data") publishes T relayed;                           // data_out in OpenRTM
    @name("more") @openrtm_name("others") publishes T more;      // others
};
```

Choose the name yourself with `@openrtm_name("...")`, or give the ports different names.
""",
)

SAME_NAME = Rule(
    "RTC0561",
    "two ports of one name in OpenRTM",
    Severity.ERROR,
    """
Two ports of a component would be registered under one name, which OpenRTM refuses. This comes of
`@openrtm_name`, or of a port that is called as the new name of another one (`RTC0560`):

```idl
component Relay {
    consumes T data;
    @name("data") publishes T relayed;    // data_out in OpenRTM
    publishes T data_out;                 // RTC0561
};
```

Give one of them another `@openrtm_name("...")`.
""",
)

TWO_NAMES = Rule(
    "RTC0562",
    "service port with two names",
    Severity.ERROR,
    """
The interfaces of one service port share the port, so `@openrtm_name` may stand at one of them, or
say the same at each.
""",
)

PACKAGE = Rule(
    "RTC0563",
    "package in the place of the modules",
    Severity.ERROR,
    """
The modules for OpenRTM stand in the folder `openrtm` of the output folder, so the generated package
cannot be called `openrtm` as well. Choose another `[output] package` in rtgen.toml.
""",
)

SAME_FOLDER = Rule(
    "RTC0564",
    "two components with one folder",
    Severity.ERROR,
    """
Each component gets the folder `openrtm/<Component>`, and a manager knows it by this name alone. So
two components cannot have the same name, upper and lower case apart, not even in different IDL
modules. Rename one of them.
""",
)

OTHER_PROFILE = Rule(
    "RTC0565",
    "profile of something else",
    Severity.WARNING,
    """
A module that rtgen made stands beside its `RTC.xml`, which has what a module has no place for:
units, documentation, bounds, the exact types of parameters. Here the module was changed, or the
profile is another component's, so the definition says what the module says.
""",
)

HIDES = Rule(
    "RTC0566",
    "module that hides another one",
    Severity.ERROR,
    """
`<Component>.py` is started as a program or loaded by its name, with its folder in front of the
search path. A component that is called as a module which it needs itself, of Python, OpenRTM or
omniORB, would be found in its place:

```idl
component RTC {};      // RTC.py would stand for OpenRTM's RTC
component queue {};    // queue.py for Python's
```

Rename the component.
""",
)

CONF_TEXT = Rule(
    "RTC0567",
    "text that a configuration file cannot hold",
    Severity.ERROR,
    """
`rtc.conf` and the other configuration files of OpenRTM are lines of `key: value`. A value is in one
line, has no backslash and no control characters, and no blanks at its ends. A part of a key has no
`:` and no `=` either, and does not begin with `#` or `!`, which make a line a comment.

The category of a component is a part of a key (`<category>.<name>.config_file`), its kind of
execution context is a value, as is the active configuration set of an instance:

```idl
@rtc(category="a=b")               // RTC0567
component Wheel {};
@rtc(execution="Periodic\nExecution")   // RTC0567
component Drive {};
```

Use other characters there.
""",
)

NOT_CLASSIC = Rule(
    "RTC0570",
    "type that OpenRTM cannot have",
    Severity.ERROR,
    """
Data and calls of an OpenRTM component are omniORB's, so its types and interfaces have to be such as
omniidl 4.3 compiles: the IDL of CORBA 2.6, without `long double`. It has no `map`, `bitset`,
`bitmask`, `int8` and `uint8`, no optional members, no enumerators with values of their own; a
member called `self` breaks the class that omniidl makes.

```idl
struct Readings { map<string, double> by_name; };
component Logger {
    consumes Readings readings;    // RTC0570
};
```

Use classic types at the ports, such as a sequence of structs for a map, or generate for the target
`embedded` alone. Inheritance of structs is no problem: what omniidl compiles has the members of the
bases in each struct.
""",
)

PYTHON_MODULE = Rule(
    "RTC0571",
    "IDL module with the name of one of Python's",
    Severity.WARNING,
    """
omniidl makes a Python module of an IDL module, with its name. Where Python has one of that name,
which is loaded already, omniORB puts the types into that one: an IDL module `typing` or `time` so
breaks other code in surprising ways.

```idl
module calendar {    // RTC0571
    struct Day { long number; };
};
```

Rename the IDL module, if it is yours to rename.
""",
)

RULES = (
    RENAMED,
    SAME_NAME,
    TWO_NAMES,
    PACKAGE,
    SAME_FOLDER,
    OTHER_PROFILE,
    HIDES,
    CONF_TEXT,
    NOT_CLASSIC,
    PYTHON_MODULE,
)
