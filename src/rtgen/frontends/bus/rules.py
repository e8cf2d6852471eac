"""Rules of bus files (EDS07xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

BAD_FILE = Rule(
    "EDS0700",
    "bus file cannot be read",
    Severity.ERROR,
    """
The file cannot be opened, or is no TOML in UTF-8.

```toml
[bus
bit_rate = 500                 # gives this finding
```
""",
)

BAD_CONTENT = Rule(
    "EDS0701",
    "key or value that a bus file cannot have",
    Severity.ERROR,
    """
The content does not follow the schema of bus files (`docs/bus.schema.json`): a key is unknown or
missing, or a value is of another kind or out of its range.

```toml
[bus]
bit_rate = 333                 # gives this finding
```
""",
)

UNKNOWN_DEVICE = Rule(
    "EDS0702",
    "unknown kind of device",
    Severity.ERROR,
    """
A node names a kind of device that has no `[device.NAME]`.

```toml
[node.left]
device = "drvie"               # gives this finding
id = 1
```
""",
)

SAME_ID = Rule(
    "EDS0703",
    "node-id given twice",
    Severity.ERROR,
    """
Each node has a node-id of its own, the manager too (127 unless `manager` says otherwise).

```toml
[node.left]
device = "drive"
id = 1
[node.right]
device = "drive"
id = 1                         # gives this finding
```
""",
)

BAD_VALUE = Rule(
    "EDS0704",
    "value for no object",
    Severity.ERROR,
    """
The device has no object of that number, or it cannot be written, or its data type does not have
the value. Objects are written as index and sub-index in hexadecimal digits.

```toml
[node.left.values]
"1017" = "fast"                # gives this finding
```

Objects that `parameters`, `operations`, `factors` and `units` of a kind name must exist, too.
""",
)

BAD_MAPPING = Rule(
    "EDS0705",
    "impossible PDO",
    Severity.ERROR,
    """
A PDO that is valid, or that the bus file maps, has a mapping that cannot be: more than 64 bits, an
object that does not exist, that cannot be mapped or not in this direction, or a
reserved COB-ID. Of a PDO that is neither, this is a warning of the description (EDS05xx).
""",
)

SAME_COB_ID = Rule(
    "EDS0706",
    "COB-ID used twice",
    Severity.ERROR,
    """
Two PDOs are sent with the same CAN identifier, or one with that of SYNC or of a node's emergency
messages, so frames of both can be on the bus at once and destroy each other; or an RPDO listens to
another node's TPDO and there is no `[[link]]` that says so.
""",
)

BAD_LINK = Rule(
    "EDS0707",
    "link without its ends",
    Severity.ERROR,
    """
A link goes from a node's TPDO to another node's RPDO, which the devices have, and which carry as
many octets. An RPDO takes one TPDO.

```toml
[[link]]
from = "palette.tpdo4"
to = "motor.rpdo9"             # gives this finding if there is none
```
""",
)

NO_BIT_RATE = Rule(
    "EDS0708",
    "bit rate that a device does not have",
    Severity.WARNING,
    """
The device's description does not name the bit rate of the bus.
""",
)

OVERLOAD = Rule(
    "EDS0709",
    "bus cannot carry its messages",
    Severity.WARNING,
    """
In the worst case the messages take more time than there is, so the late ones have no bound. Lower
the rates (event timers, inhibit times, SYNC), or raise the bit rate.
""",
)

NOT_LIKE_KIND = Rule(
    "EDS0710",
    "node that is mapped unlike its kind",
    Severity.ERROR,
    """
The components of a kind of device are generated once, with the PDO mapping that its description and
the `values` of its kind give. All nodes of the kind have that mapping.

```toml
[node.left.values]
"1A00:0" = 1                   # gives this finding where the kind maps two objects
```

Write the mapping to `[device.NAME.values]`, or give the node a kind of its own, with a `name` of
its own.
""",
)

NO_SUPERVISION = Rule(
    "EDS0711",
    "node that nobody supervises",
    Severity.WARNING,
    """
The node has neither a heartbeat (1017h) nor node guarding (100Ch), so nobody notices when it fails:
its proxy stays ACTIVE, and what its inputs told last goes on to count.

```toml
[device.drive.values]
"1017" = 100                   # ms: a heartbeat, if the device has 1017h
```

A device without 1017h is polled by node guarding, if it has 100Ch and 100Dh:

```toml
[device.drive.values]
"100C" = 100                   # ms between two requests
"100D" = 3                     # lost after so many without an answer
```
""",
)

RULES = (
    BAD_FILE,
    BAD_CONTENT,
    UNKNOWN_DEVICE,
    SAME_ID,
    BAD_VALUE,
    BAD_MAPPING,
    SAME_COB_ID,
    BAD_LINK,
    NO_BIT_RATE,
    OVERLOAD,
    NOT_LIKE_KIND,
    NO_SUPERVISION,
)
