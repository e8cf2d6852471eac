"""The rules of lowering CANopen devices (EDS0800 to EDS0804)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

SAME_MODULE = Rule(
    "EDS0800",
    "two devices of one name",
    Severity.ERROR,
    """
Each kind of device gets an IDL module and components of its own, called after its file or after
`name` in the bus file. Two kinds may share a name only where the same comes out: the same file with
the same settings and the same PDO mapping.

```toml
[device.slow]
eds = "drive.eds"
[device.fast]
eds = "drive.eds"
ports = "object"               # gives this finding; add: name = "FastDrive"
```

Names that differ in case only are the same, as in IDL.
""",
)

TAKEN_MODULE = Rule(
    "EDS0801",
    "name that a device cannot have",
    Severity.ERROR,
    """
A device's IDL module, its Python package or its components would be called as something that
projects with CANopen devices have already: the modules `RTC`, `CANopen` and `CORBA`, the generated
packages `components` and `networks`.

Rename the file, or give the kind another `name` in the bus file.
""",
)

NO_PORT = Rule(
    "EDS0802",
    "PDO without a port",
    Severity.WARNING,
    """
The mapping of a PDO cannot be laid out: it has more than 64 bits, text or octets that do not begin
and end at an octet, or a type in another length than it has. The components have no port for it;
the rest of the device is generated.
""",
)

BAD_PARAMETER = Rule(
    "EDS0803",
    "object that cannot be a parameter",
    Severity.ERROR,
    """
Configuration parameters are written to the device, and are numbers, booleans or text. An object
that cannot be written, or that is a domain or a time, cannot be one.

```toml
[device.drive]
eds = "drive.eds"
parameters = ["6041"]          # gives this finding: the status word is read-only
```
""",
)

NO_DEFAULT = Rule(
    "EDS0804",
    "parameter without a default",
    Severity.WARNING,
    """
The description has no value for an object that becomes a configuration parameter, so the parameter
is 0 or empty unless it is set, and that is written to the device when the proxy is activated.

```toml
[device.drive.values]
"6083" = 1000                  # helps
```
""",
)

RULES = (SAME_MODULE, TAKEN_MODULE, NO_PORT, BAD_PARAMETER, NO_DEFAULT)
