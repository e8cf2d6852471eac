"""Rules of regions and of plug-ins on joins (CDL07xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

SPECIFIERS_AGAIN = Rule(
    "CDL0700",
    "specifiers where a region is opened again",
    Severity.ERROR,
    """
A region has its specifiers where it appears first.

```cdl
// gives this finding
region rOne {};
[linkunit] region rOne {};
```

tecsgen's message: S1140.
""",
)

NAME_OF_ANOTHER = Rule(
    "CDL0701",
    "name of a region or name space taken",
    Severity.ERROR,
    """
A region, or a name space, can be opened again; the name of something else it cannot have.

```cdl
// gives this finding
signature sWork { void work( void ); };
region sWork {};
```

tecsgen's message: S1141, S1151 and S2001.
""",
)

GOING_OUT = Rule(
    "CDL0702",
    "join out of a region",
    Severity.ERROR,
    """
A join may leave a region that has `out_through`.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
region rOne { cell tUser User { cWork = Worker.eWork; }; };
```

tecsgen's message: S1118.
""",
)

GOING_TO = Rule(
    "CDL0703",
    "join between regions",
    Severity.ERROR,
    """
A join from one region to the next has `to_through( that region, ... )` there.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
region rTwo { cell tWorker Worker {}; };
[to_through( rThree, TracePlugin, "" )]
region rOne { cell tUser User { cWork = rTwo::Worker.eWork; }; };
```

tecsgen's message: S1119.
""",
)

GOING_IN = Rule(
    "CDL0704",
    "join into a region",
    Severity.ERROR,
    """
A join may enter a region that has `in_through`.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
region rOne { cell tWorker Worker {}; };
cell tUser User { cWork = rOne::Worker.eWork; };
```

tecsgen's message: S1120.
""",
)

LINK_UNITS = Rule(
    "CDL0705",
    "join between link units",
    Severity.ERROR,
    """
Cells of different link units are different programs: a plug-in is needed between them.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
[linkunit, in_through()] region rOne { cell tWorker Worker {}; };
cell tUser User { cWork = rOne::Worker.eWork; };
```

tecsgen's message: S1121.
""",
)

KIND_TWICE = Rule(
    "CDL0706",
    "two kinds of one region",
    Severity.ERROR,
    """
A region is one of `node` and `linkunit`, and one of `domain` and `class`.

```cdl
// gives this finding
[linkunit, node] region rOne {};
```

tecsgen's message: S1178 and S9999.
""",
)

UNKNOWN_PLUGIN = Rule(
    "CDL0710",
    "unknown plug-in",
    Severity.WARNING,
    """
The plug-in is neither ours nor one that tecsgen ships. It is left to tecsgen, which looks for it
on its library path.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { [through( RTPPlugin, "" )] cWork = Worker.eWork; };
```

tecsgen's message: P2001.
""",
)

THROUGH_ATTRIBUTE = Rule(
    "CDL0711",
    "through before something that is no join",
    Severity.WARNING,
    """
`through` stands before the join of a call port; before anything else it has no effect.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; attr { int32_t number; }; };
cell tWorker Worker { [through( RTCPlugin, "" )] number = 1; };
```

tecsgen's message: S1123.
""",
)

THROUGH_IGNORED = Rule(
    "CDL0712",
    "through without effect",
    Severity.WARNING,
    """
A call port that is `omit`, or has a signature without functions, carries no calls, so nothing is
put between.

```cdl
// gives this finding
signature sNone {};
celltype tWorker { entry sNone eNone; };
[active] celltype tUser { call sNone cNone; };
cell tWorker Worker {};
cell tUser User { [through( RTCPlugin, "" )] cNone = Worker.eNone; };
```

tecsgen's message: W9999.
""",
)

BAD_ARGUMENT = Rule(
    "CDL0713",
    "malformed argument of a plug-in",
    Severity.ERROR,
    """
The argument is a list `name=value, name=value`. A value may stand between `\\\"` `\\\"`, `'` `'`,
`%` `%` or `!` `!`; a backslash quotes the next character.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { [through( RTCPlugin, "port 8931" )] cWork = Worker.eWork; };
```

tecsgen's message: P1001, P1002 and P1003.
""",
)

OPTION_TWICE = Rule(
    "CDL0714",
    "option given twice",
    Severity.WARNING,
    """
Of an option that is given twice the last value counts.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { [through( RTCPlugin, "port=8931, port=8932" )] cWork = Worker.eWork; };
```
""",
)

UNKNOWN_SUBSTITUTION = Rule(
    "CDL0715",
    "unknown word between dollars",
    Severity.ERROR,
    """
In the argument of a plug-in `$source$`, `$destination$` and `$next$` stand for cells, in capitals
for their names in C, `$start_region$`, `$end_region$` and `$preferred_region$` for regions,
`$count$` for a running number, `$$` for a dollar.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { [through( RTCPlugin, "name=$cell$" )] cWork = Worker.eWork; };
```
""",
)

RULES: tuple[Rule, ...] = (
    SPECIFIERS_AGAIN,
    NAME_OF_ANOTHER,
    GOING_OUT,
    GOING_TO,
    GOING_IN,
    LINK_UNITS,
    KIND_TWICE,
    UNKNOWN_PLUGIN,
    THROUGH_ATTRIBUTE,
    THROUGH_IGNORED,
    BAD_ARGUMENT,
    OPTION_TWICE,
    UNKNOWN_SUBSTITUTION,
)
