"""Rules of regions and of plug-ins on joins (CDL07xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

SPECIFIERS_AGAIN = Rule(
    "CDL0700",
    "specifiers where a region is opened again",
    Severity.ERROR,
    """
A region has its specifiers where it appears first. tecsgen: S1140.

```cdl
// gives this finding
region rOne {};
[linkunit] region rOne {};
```
""",
)

NAME_OF_ANOTHER = Rule(
    "CDL0701",
    "name of a region or name space taken",
    Severity.ERROR,
    """
A region, or a name space, can be opened again; the name of something else it cannot have.
tecsgen: S1141, S1151, S2001.

```cdl
// gives this finding
signature sWork { void work( void ); };
region sWork {};
```
""",
)

GOING_OUT = Rule(
    "CDL0702",
    "join out of a region",
    Severity.ERROR,
    """
A join may leave a region that has `out_through`. tecsgen: S1118.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
region rOne { cell tUser User { cWork = Worker.eWork; }; };
```
""",
)

GOING_TO = Rule(
    "CDL0703",
    "join between regions",
    Severity.ERROR,
    """
A join from one region to the next has `to_through( that region, ... )` there. tecsgen: S1119.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
region rTwo { cell tWorker Worker {}; };
[to_through( rThree, TracePlugin, "" )]
region rOne { cell tUser User { cWork = rTwo::Worker.eWork; }; };
```
""",
)

GOING_IN = Rule(
    "CDL0704",
    "join into a region",
    Severity.ERROR,
    """
A join may enter a region that has `in_through`. tecsgen: S1120.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
region rOne { cell tWorker Worker {}; };
cell tUser User { cWork = rOne::Worker.eWork; };
```
""",
)

LINK_UNITS = Rule(
    "CDL0705",
    "join between link units",
    Severity.ERROR,
    """
Cells of different link units are different programs: a plug-in is needed between them. tecsgen:
S1121.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
[linkunit, in_through()] region rOne { cell tWorker Worker {}; };
cell tUser User { cWork = rOne::Worker.eWork; };
```
""",
)

KIND_TWICE = Rule(
    "CDL0706",
    "two kinds of one region",
    Severity.ERROR,
    """
A region is one of `node` and `linkunit`, and one of `domain` and `class`. tecsgen: S1178, S9999.

```cdl
// gives this finding
[linkunit, node] region rOne {};
```
""",
)

UNKNOWN_PLUGIN = Rule(
    "CDL0710",
    "unknown plug-in",
    Severity.WARNING,
    """
The plug-in is neither ours nor one that tecsgen ships. It is left to tecsgen, which looks for it
on its library path. tecsgen: P2001.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { [through( RTPPlugin, "" )] cWork = Worker.eWork; };
```
""",
)

THROUGH_ATTRIBUTE = Rule(
    "CDL0711",
    "through before something that is no join",
    Severity.WARNING,
    """
`through` stands before the join of a call port; before anything else it has no effect. tecsgen:
S1123.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; attr { int32_t number; }; };
cell tWorker Worker { [through( RTCPlugin, "" )] number = 1; };
```
""",
)

THROUGH_IGNORED = Rule(
    "CDL0712",
    "through without effect",
    Severity.WARNING,
    """
A call port that is `omit`, or has a signature without functions, carries no calls, so nothing is
put between. tecsgen: W9999.

```cdl
// gives this finding
signature sNone {};
celltype tWorker { entry sNone eNone; };
[active] celltype tUser { call sNone cNone; };
cell tWorker Worker {};
cell tUser User { [through( RTCPlugin, "" )] cNone = Worker.eNone; };
```
""",
)

BAD_ARGUMENT = Rule(
    "CDL0713",
    "malformed argument of a plug-in",
    Severity.ERROR,
    """
The argument is a list `name=value, name=value`. A value may stand between `\\\"` `\\\"`, `'` `'`,
`%` `%` or `!` `!`; a backslash quotes the next character. tecsgen: P1001, P1002, P1003.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { [through( RTCPlugin, "port 8931" )] cWork = Worker.eWork; };
```
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
