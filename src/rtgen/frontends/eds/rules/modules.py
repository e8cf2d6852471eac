"""Rules of modular devices (EDS06xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NO_MODULE = Rule(
    "EDS0600",
    "unknown module",
    Severity.WARNING,
    """
`[ConnectedModules]` names a kind of module that `[SupportedModules]` does not count, or a section
belongs to such a module. It is passed over.

```ini
[SupportedModules]
NrOfEntries=1
[ConnectedModules]
NrOfEntries=1
1=4                            ; gives this finding
```
""",
)

NOTHING_TO_EXTEND = Rule(
    "EDS0601",
    "module extends no object",
    Severity.WARNING,
    """
A module adds sub-objects to an object that the device does not have, or that takes none: it is a
variable, or all 254 sub-indices are taken and the module names no object to go on with.

```ini
[M1SubExt6000]                 ; gives this finding if there is no [6000]
Count=2
```
""",
)

RULES = (NO_MODULE, NOTHING_TO_EXTEND)
