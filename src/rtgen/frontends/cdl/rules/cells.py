"""Rules of cells and joins (CDL06xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_CELLTYPE = Rule(
    "CDL0600",
    "celltype not found",
    Severity.ERROR,
    """
A cell is of a celltype or composite that is declared before it, here or in an imported file.
tecsgen: S1027.

```cdl
// gives this finding
cell tWorker Worker {};
```
""",
)

NOT_A_CELLTYPE = Rule(
    "CDL0601",
    "not a celltype",
    Severity.ERROR,
    """
The name that a cell has in the place of its celltype stands for something else. tecsgen: S1028.

```cdl
// gives this finding
signature sWork { void work( void ); };
cell sWork Worker {};
```
""",
)

CELL_MISMATCH = Rule(
    "CDL0602",
    "cell declared again as something else",
    Severity.ERROR,
    """
A prototype and the cell that it announces have the same name, celltype and region; nothing else
there has that name. tecsgen: S1029, S1030, S1031.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
celltype tOther { entry sWork eWork; };
cell tWorker Worker;
cell tOther Worker {};
```
""",
)

CELL_TWICE = Rule(
    "CDL0603",
    "cell defined twice",
    Severity.ERROR,
    """
A cell has one body. It can be announced by `cell tType Name;` before. tecsgen: S1032.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
cell tWorker Worker {};
cell tWorker Worker {};
```
""",
)

CELL_IN_NAMESPACE = Rule(
    "CDL0604",
    "cell in a name space",
    Severity.ERROR,
    """
Cells stand at the top or in regions. tecsgen: S9999.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
namespace nBox { cell ::tWorker Worker {}; };
```
""",
)

SECOND_SINGLETON = Rule(
    "CDL0605",
    "second cell of a singleton",
    Severity.ERROR,
    """
There is one cell of a singleton in a link unit; a composite counts for the cells inside it.
tecsgen: S1024.

```cdl
// gives this finding
signature sWork { void work( void ); };
[singleton] celltype tKernel { entry sWork eWork; };
cell tKernel One {};
cell tKernel Two {};
```
""",
)

UNDEFINED_CELL = Rule(
    "CDL0606",
    "cell used, but never defined",
    Severity.ERROR,
    """
A cell that is announced by a prototype, and used, needs a body. tecsgen: S1093.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker;
cell tUser User { cWork = Worker.eWork; };
```
""",
)

UNUSED_PROTOTYPE = Rule(
    "CDL0607",
    "prototype of a cell that is neither used nor defined",
    Severity.NOTE,
    """
A prototype announces a cell for a later use. tecsgen: W1006.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
cell tWorker Worker;
```
""",
)

UNUSED_CELL = Rule(
    "CDL0608",
    "cell that nobody calls",
    Severity.WARNING,
    """
No call port is joined to the cell; it is not of an active celltype, nor has its celltype a
factory. tecsgen: W1007.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
cell tWorker Worker {};
```
""",
)

PROTOTYPE = Rule(
    "CDL0609",
    "prototype that cannot be one",
    Severity.ERROR,
    """
A cell with `[prototype]` is defined elsewhere, behind it; plug-ins are applied where it is
defined. tecsgen: S9999.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
cell tWorker Worker {};
[prototype] cell tWorker Worker {};
```
""",
)

UNKNOWN_CELL = Rule(
    "CDL0610",
    "cell not found",
    Severity.ERROR,
    """
A join names a cell; it may be defined further down. tecsgen: S1109, S9999.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser User { cWork = Worker.eWork; };
```
""",
)

NOT_A_CELL = Rule(
    "CDL0611",
    "not a cell",
    Severity.ERROR,
    """
The name to the left of the dot in a join stands for something that is no cell. tecsgen: S1110.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser User { cWork = tWorker.eWork; };
```
""",
)

UNKNOWN_ENTRY = Rule(
    "CDL0612",
    "cell has no such port",
    Severity.ERROR,
    """
A join names an entry port of the celltype of the cell. tecsgen: S1111.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { cWork = Worker.eOther; };
```
""",
)

NOT_AN_ENTRY = Rule(
    "CDL0613",
    "not an entry port",
    Severity.ERROR,
    """
A join leads to an entry port. tecsgen: S1112.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser One { cWork = Two.cWork; };
cell tUser Two { cWork = One.cWork; };
```
""",
)

SIGNATURE_MISMATCH = Rule(
    "CDL0614",
    "call port and entry port of different signatures",
    Severity.ERROR,
    """
Both ends of a join have the same signature. Signatures that look alike are not the same. tecsgen:
S1113.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
signature sOther { void work( void ); };
[active] celltype tUser { call sOther cWork; };
cell tWorker Worker {};
cell tUser User { cWork = Worker.eWork; };
```
""",
)

LEFT_SUBSCRIPT = Rule(
    "CDL0615",
    "subscript of a call port",
    Severity.ERROR,
    """
A call port array is joined with a subscript, `cPort[0]` or `cPort[]`, which is a constant and not
negative; another call port without. tecsgen: S1099, S1102, S1103.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { cWork[0] = Worker.eWork; };
```
""",
)

RIGHT_SUBSCRIPT = Rule(
    "CDL0616",
    "subscript of an entry port",
    Severity.ERROR,
    """
The entry port of an array is named with a subscript within its size, another one without.
tecsgen: S1114, S1115, S1116.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork[2]; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { cWork = Worker.eWork[2]; };
```
""",
)

UNKNOWN_NAME = Rule(
    "CDL0617",
    "celltype has no such port or attribute",
    Severity.ERROR,
    """
What a cell sets is a call port or an attribute of its celltype. tecsgen: S1117.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
cell tWorker Worker { number = 1; };
```
""",
)

ENTRY_ON_THE_LEFT = Rule(
    "CDL0618",
    "entry port where a call port should stand",
    Severity.ERROR,
    """
A join is written at the caller: `cCall = Cell.eEntry;`. tecsgen: S1101.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser User { cWork = Worker.eWork; };
cell tWorker Worker { eWork = User.cWork; };
```
""",
)

VARIABLE_IN_CELL = Rule(
    "CDL0619",
    "variable set by a cell",
    Severity.ERROR,
    """
A cell sets attributes; a variable has its first value from the celltype. tecsgen: S1100.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; var { int32_t count; }; };
cell tWorker Worker { count = 1; };
```
""",
)

NOT_A_TARGET = Rule(
    "CDL0620",
    "call port joined to something else",
    Severity.ERROR,
    """
A call port is joined to `Cell.ePort` or `Cell.ePort[i]`. tecsgen: S1108.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser User { cWork = 1; };
```
""",
)

JOINED_TWICE = Rule(
    "CDL0621",
    "joined or set twice",
    Severity.ERROR,
    """
A call port, each place of an array, and an attribute are set once. `[]` and numbers do not mix.
tecsgen: S1127 to S1130.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tWorker Worker {};
cell tUser User { cWork = Worker.eWork; cWork = Worker.eWork; };
```
""",
)

NOT_JOINED = Rule(
    "CDL0622",
    "call port without a join",
    Severity.ERROR,
    """
Every call port is joined, except with `optional`. A port named `<port>_<function>_<parameter>`
was made for the allocator of a send or receive parameter. tecsgen: S1042, S1043.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser User {};
```
""",
)

ARRAY_HOLE = Rule(
    "CDL0623",
    "call port array with another number of joins",
    Severity.ERROR,
    """
Each place of a call port array is joined, unless it is `optional`, and there are as many as its
size. tecsgen: S1044, S1045, S1046.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork[2]; };
cell tWorker Worker {};
cell tUser User { cWork[1] = Worker.eWork; };
```
""",
)

NO_VALUE = Rule(
    "CDL0624",
    "attribute without a value",
    Severity.ERROR,
    """
An attribute has its value from the celltype or from the cell. tecsgen: S1052.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; attr { int32_t number; }; };
cell tWorker Worker {};
```
""",
)

BAD_ID = Rule(
    "CDL0625",
    "impossible id",
    Severity.ERROR,
    """
An id is a constant integer, not zero. Negative ones count from the end. tecsgen: S1160, S1161,
S1162.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[id( 0 )] cell tWorker Worker {};
```
""",
)

ID_TAKEN = Rule(
    "CDL0626",
    "id too large or taken",
    Severity.ERROR,
    """
The ids of a celltype in a link unit are the numbers from 1 to the number of its cells. tecsgen:
S3001, S3002, S3003.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[id( 2 )] cell tWorker Worker {};
```
""",
)

REVERSE_JOIN = Rule(
    "CDL0627",
    "reverse join that cannot be",
    Severity.ERROR,
    """
`eEntry <= Cell.cCall;` stands in a prototype, or the signature is `callback`. tecsgen: S9999.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
cell tUser User;
cell tWorker Worker { eWork <= User.cWork; };
cell tUser User {};
```
""",
)

NOT_REACHED = Rule(
    "CDL0628",
    "required cell not reached",
    Severity.ERROR,
    """
What a celltype requires is looked for among the cells that can be reached from the region of the
cell: the nearest one counts. tecsgen: S1025, S1026.

```cdl
// gives this finding
signature sWork { void work( void ); };
[singleton] celltype tKernel { entry sWork eWork; };
[active] celltype tUser { require tKernel.eWork; };
cell tUser User {};
```
""",
)

REQUIRE_OVERRIDDEN = Rule(
    "CDL0629",
    "required port joined by the cell",
    Severity.WARNING,
    """
The cell joins a port that `require` would join by itself; the join of the cell counts. tecsgen:
W1003.

```cdl
// gives this finding
signature sWork { void work( void ); };
[singleton] celltype tKernel { entry sWork eWork; };
[active] celltype tUser { require cWork = tKernel.eWork; };
cell tKernel Kernel {};
cell tUser User { cWork = Kernel.eWork; };
```
""",
)

RESTRICT = Rule(
    "CDL0630",
    "region of restrict not found",
    Severity.ERROR,
    """
`restrict` names regions, from which the cell may be called. tecsgen: S9999.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[restrict( eWork = { rNowhere } )] cell tWorker Worker {};
```
""",
)

RELAY = Rule(
    "CDL0631",
    "allocator that cannot be passed on",
    Severity.ERROR,
    """
An allocator is passed on from a call port that is joined; neither side is an array, and in a
composite both ends lead to the same one. tecsgen: S1040, S1041, S1167.

```cdl
// gives this finding
signature sAlloc {
  ER alloc( [in] int32_t size, [out] void **p );
  ER dealloc( [in] const void *p );
};
signature sWork { ER work( [send( sAlloc ), size_is( n )] uint8_t *data, [in] int32_t n ); };
celltype tRelay {
  [allocator( work.data <= cWork.work.data )] entry sWork eWork;
  call sWork cWork;
};
celltype tLast { entry sWork eWork; };
cell tLast Last;
cell tRelay Relay { cWork = Last.eWork; };
celltype tAlloc { entry sAlloc eAlloc; };
cell tAlloc Alloc {};
cell tLast Last { eWork_work_data = Alloc.eAlloc; };
```
""",
)

NOT_A_CHOICE = Rule(
    "CDL0632",
    "value that is none of the choices",
    Severity.WARNING,
    """
An attribute with `choice` has one of the values listed.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; attr { [choice = { "FAST", "SLOW" }] char_t *mode; }; };
cell tWorker Worker { mode = "QUICK"; };
```
""",
)

MANY_CALLERS = Rule(
    "CDL0633",
    "fixed join beside another join",
    Severity.WARNING,
    """
An entry port with a fixed join is called from there; the cell is joined from elsewhere, too.
tecsgen: W1009.

```cdl
// gives this finding
signature sWork { void work( void ); };
[singleton, active] celltype tOne { call sWork cWork[]; };
celltype tWorker { entry sWork eWork <= tOne.cWork; };
[active] celltype tUser { call sWork cWork; };
cell tOne One {};
cell tWorker Worker {};
cell tUser User { cWork = Worker.eWork; };
```
""",
)

GENERATE_TARGET = Rule(
    "CDL0634",
    "target of generate not found",
    Severity.ERROR,
    """
`generate( plug-in, target, "arguments" );` names a signature, celltype, composite or cell that is
declared before. tecsgen: S9999.

```cdl
// gives this finding
generate( TracePlugin, sWork, "" );
```
""",
)

MADE_BY_PLUGIN = Rule(
    "CDL0635",
    "what a plug-in may declare or join",
    Severity.NOTE,
    """
The name is not declared here, or the call port not joined. It may be among what a plug-in of
tecsgen declares that was applied before, or joins by itself, so it is taken for right.

```cdl
// gives this finding
signature sWork { void work( void ); };
generate( MrubyBridgePlugin, sWork, "" );
cell nMruby::tsWork Bridge {};
```
""",
)

ALLOCATOR_OF_CELL = Rule(
    "CDL0636",
    "allocator of a cell that names nothing",
    Severity.ERROR,
    """
`[allocator( ePort.func.par = Cell.eAlloc )]` names a send or receive parameter of an entry port
of the cell. tecsgen: S1117.

```cdl
// gives this finding
signature sWork { void work( [in] int32_t n ); };
celltype tWorker { entry sWork eWork; };
[allocator( eWork.work.n = Worker.eWork )] cell tWorker Worker {};
```
""",
)

RULES: tuple[Rule, ...] = (
    UNKNOWN_CELLTYPE,
    NOT_A_CELLTYPE,
    CELL_MISMATCH,
    CELL_TWICE,
    CELL_IN_NAMESPACE,
    SECOND_SINGLETON,
    UNDEFINED_CELL,
    UNUSED_PROTOTYPE,
    UNUSED_CELL,
    PROTOTYPE,
    UNKNOWN_CELL,
    NOT_A_CELL,
    UNKNOWN_ENTRY,
    NOT_AN_ENTRY,
    SIGNATURE_MISMATCH,
    LEFT_SUBSCRIPT,
    RIGHT_SUBSCRIPT,
    UNKNOWN_NAME,
    ENTRY_ON_THE_LEFT,
    VARIABLE_IN_CELL,
    NOT_A_TARGET,
    JOINED_TWICE,
    NOT_JOINED,
    ARRAY_HOLE,
    NO_VALUE,
    BAD_ID,
    ID_TAKEN,
    REVERSE_JOIN,
    NOT_REACHED,
    REQUIRE_OVERRIDDEN,
    RESTRICT,
    RELAY,
    NOT_A_CHOICE,
    MANY_CALLERS,
    GENERATE_TARGET,
    MADE_BY_PLUGIN,
    ALLOCATOR_OF_CELL,
)
