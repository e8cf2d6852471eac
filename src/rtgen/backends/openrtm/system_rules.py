"""The rules of systems on the target openrtm."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

SYSTEM_FOLDER = Rule(
    "RTC0587",
    "system in the place of another one",
    Severity.ERROR,
    """
A system gets the folder `openrtm/<system>`, after the stem of its file, or after its folder for a
`system.xml`. A component, or another system, has that folder already. Rename the file.
""",
)

LONELY_CONSUMER = Rule(
    "RTC0588",
    "consumer without a provider",
    Severity.WARNING,
    """
A service connector joins a port whose consumer finds no provider of its interface at the other
end. In OpenRTM a call would have no object to go to. Connect it to a port that provides the
interface, or tell the pair in a property of the connector:

```xml
<rtsExt:Properties rtsExt:name="A0.port.service.required.Demo::Lamp.lamp"
    rtsExt:value="B0.port.service.provided.Demo::Lamp.left"/>
```
""",
)

PER_CYCLE = Rule(
    "RTC0589",
    "parameter for one execution that is none",
    Severity.ERROR,
    """
The property `rtgen.openrtm.per_cycle` of a system lists, with commas between them, the parameters
`INSTANCE.PARAMETER` that are meant for one execution. `start.sh --rate-scale` divides them by the
scale. One of them is not there, or is no number.
""",
)

OWN_PORT = Rule(
    "RTC0590",
    "connector that OpenRTM cannot have",
    Severity.WARNING,
    """
A connector of the system goes to a port that a behaviour makes itself (`rtgen.own_port`). The
module for OpenRTM has the ports of the definition only, so the connector is left out there. Put the
port into the definition to have it everywhere.
""",
)

INSTANCE_NAME = Rule(
    "RTC0591",
    "instance name that cannot be a file name",
    Severity.ERROR,
    """
On OpenRTM an instance has a `.conf` file, a log and a name in the naming service, all after its
instance name. So the name has no `/`, `\\`, `:` or `=`, no control characters and no blanks at its
ends, and does not begin with `#` or `!`.
""",
)

RULES = (SYSTEM_FOLDER, LONELY_CONSUMER, PER_CYCLE, OWN_PORT, INSTANCE_NAME)
