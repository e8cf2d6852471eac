"""The rules of the target small."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

LEFT_OUT = Rule(
    "RTC0600",
    "component without a small form",
    Severity.WARNING,
    """
The target small has fixed buffers and no ORB. A component gets no small form if it has service
ports, a base class of its own (as CANopen components have), parameters that are sequences, or
ports of types with unions, `any`, wide text, `long double`, `fixed`, maps, recursion, or sequences
and arrays within each other:

```idl
component Guard {
    consumes RTC::TimedWString text;    // RTC0600
};
```

The other components of the definitions are emitted. Sequences and strings without a bound get that
of `[small]` in rtgen.toml: `sequence` (default 1024 items) and `string` (default 128 octets).
""",
)

RULES = (LEFT_OUT,)
