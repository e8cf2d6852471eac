"""The rules of adapters, `[adapter.NAME]` of rtgen.toml (codes ADP...)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

ADAPTER_NAME = Rule(
    "ADP0001",
    "adapter without a name of its own",
    Severity.ERROR,
    """
An adapter becomes a component of that name, so it is an identifier, and no definition of the
project has it.

```toml
[adapter.VelocityAdapter]
from = "RTC::TimedVelocity"
to = "IIS::TimedVelocity2D"
map = { "data.vx" = "v", "data.va" = "w" }
```
""",
)

ADAPTER_TYPE = Rule(
    "ADP0002",
    "adapter between what is no struct",
    Severity.ERROR,
    """
`from` and `to` of an adapter are the scoped names of structs, which data ports can carry, in the
definitions of the project.

```toml
[adapter.VelocityAdapter]
from = "TimedVelocity"          # wrong
from = "RTC::TimedVelocity"     # right
```
""",
)

ADAPTER_MEMBER = Rule(
    "ADP0003",
    "adapter with an unknown member",
    Severity.ERROR,
    """
`map` of an adapter has the members of `to` on the left, those of `from` that they are filled with
on the right; a dot leads into a struct.

```toml
map = { "data.vx" = "v", "data.va" = "w" }
```

Members that have one name and one type in both structs need not be told: they are copied. Others
keep their default.
""",
)

ADAPTER_VALUE = Rule(
    "ADP0004",
    "members that do not fit",
    Severity.ERROR,
    """
A member can be filled with one of the same type, and a number with one that it can hold in any
case: a `double` with a `float` or a `long`, a `long` with a `short`. No member is filled twice.
""",
)

RULES: tuple[Rule, ...] = (
    ADAPTER_NAME,
    ADAPTER_TYPE,
    ADAPTER_MEMBER,
    ADAPTER_VALUE,
)
