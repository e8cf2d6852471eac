"""The rules of the CANopen back end (EDS0805)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

NOT_WRITABLE = Rule(
    "EDS0805",
    "value that cannot be written to a node",
    Severity.ERROR,
    """
What a bus file or a DCF gives an object cannot be sent to the device: a character that is not of
Latin-1, a number that its data type does not have, or a value that depends on a node-id.

```toml
[node.left.values]
"2001" = "\u5de6"              # gives this finding where 2001h is a VISIBLE_CHAR (A0h)
```
""",
)

RULES = (NOT_WRITABLE,)
