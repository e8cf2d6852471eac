"""Rules of celltypes and composites (CDL05xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_SIGNATURE = Rule(
    "CDL0500",
    "signature not found",
    Severity.ERROR,
    """
A port names a signature that is declared before it, here or in an imported file. tecsgen: S1075.

```cdl
// gives this finding
celltype tWorker { entry sWork eWork; };
```
""",
)

NOT_A_SIGNATURE = Rule(
    "CDL0501",
    "not a signature",
    Severity.ERROR,
    """
The name that a port has in the place of its signature stands for something else. tecsgen: S1076.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
celltype tUser { call tWorker cWork; entry sWork eWork; };
```
""",
)

BAD_PORT_SIZE = Rule(
    "CDL0502",
    "size of a port array",
    Severity.ERROR,
    """
The size of a port array is a constant integer. tecsgen: S1073, S1074.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork[1.5]; };
```
""",
)

PORT_SPECIFIER = Rule(
    "CDL0503",
    "specifier on the wrong kind of port",
    Severity.ERROR,
    """
`inline` and `allocator` belong to entry ports; `optional`, `omit`, `dynamic` and `ref_desc` to
call ports. tecsgen: S1077, S1078, S1079, S9999.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { [optional] entry sWork eWork; };
```
""",
)

SPECIFIERS_CLASH = Rule(
    "CDL0504",
    "specifiers that exclude each other",
    Severity.ERROR,
    """
A port cannot be `dynamic` or `ref_desc` and at the same time `omit`, nor of a signature without
functions. tecsgen: S9999.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tUser { [dynamic, omit] call sWork cWork; entry sWork eWork; };
```
""",
)

SPECIFIER_TWICE = Rule(
    "CDL0506",
    "specifier given twice",
    Severity.ERROR,
    """
`generate` and `allocator` are given once. tecsgen: S1014, S1080, S1163.

```cdl
// gives this finding
signature sWork {};
[generate( CIfGenPlugin, "" ), generate( CIfGenPlugin, "" )]
celltype tWorker { entry sWork eWork; };
```
""",
)

NAME_TWICE = Rule(
    "CDL0507",
    "name declared twice in a celltype",
    Severity.ERROR,
    """
Ports, attributes and variables of a celltype or composite have different names. tecsgen: S2001.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t eWork = 1; }; };
```
""",
)

BAD_FIXED_JOIN = Rule(
    "CDL0508",
    "fixed join that cannot be",
    Severity.ERROR,
    """
`entry sSig eName <= tOther.cArr;` joins every cell of the celltype to a call port array without a
size of a singleton. tecsgen: S1152 to S1158.

```cdl
// gives this finding
signature sWork {};
celltype tOne { call sWork cWork; entry sWork eWork; };
celltype tWorker { entry sWork eWork <= tOne.cWork; };
```
""",
)

UNKNOWN_REQUIRED = Rule(
    "CDL0509",
    "required celltype or cell not found",
    Severity.ERROR,
    """
What `require` names is a celltype or cell that is declared before. tecsgen: S1016, S1017.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { require tKernel.eKernel; entry sWork eWork; };
```
""",
)

REQUIRED_NOT_SINGLETON = Rule(
    "CDL0510",
    "required celltype is no singleton",
    Severity.ERROR,
    """
`require` needs no join, so there can be one cell only. tecsgen: S1018.

```cdl
// gives this finding
signature sWork {};
celltype tKernel { entry sWork eKernel; };
celltype tWorker { require tKernel.eKernel; entry sWork eWork; };
```
""",
)

REQUIRED_NOT_ENTRY = Rule(
    "CDL0511",
    "required port is no single entry port",
    Severity.ERROR,
    """
`require` names an entry port that is no array. tecsgen: S1019, S1020.

```cdl
// gives this finding
signature sWork {};
[singleton] celltype tKernel { entry sWork eKernel; };
celltype tWorker { require tKernel.eOther; entry sWork eWork; };
```
""",
)

REQUIRE_CLASH = Rule(
    "CDL0512",
    "functions of one name required twice",
    Severity.ERROR,
    """
Functions of a port that is required without a name are called by their bare names, so no two of
them are alike. tecsgen: S1021, S1022.

```cdl
// gives this finding
signature sA { void work( void ); };
signature sB { void work( void ); };
[singleton] celltype tA { entry sA eA; };
[singleton] celltype tB { entry sB eB; };
celltype tWorker { require tA.eA; require tB.eB; entry sA eWork; };
```
""",
)

UNKNOWN_FACTORY_FUNCTION = Rule(
    "CDL0513",
    "unknown function in a factory",
    Severity.ERROR,
    """
The only function of a factory is `write`. tecsgen: S1134.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; factory { print( "a.cfg", "text" ); }; };
```
""",
)

FACTORY_TEXT = Rule(
    "CDL0514",
    "file or format of write is no string",
    Severity.ERROR,
    """
The first argument of `write` is the name of a file, the second a format; both are strings.
tecsgen: S1132, S1133.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; factory { write( 1, "text" ); }; };
```
""",
)

FACTORY_ARGUMENT = Rule(
    "CDL0515",
    "argument of write is no attribute",
    Severity.ERROR,
    """
Behind the format of `write` stand attributes and strings; in `FACTORY`, which is for the celltype
and not for a cell, nothing. tecsgen: S1135, S1136, S1137.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; factory { write( "a.cfg", "%s", missing ); }; };
```
""",
)

SIZE_IS_OF_NO_POINTER = Rule(
    "CDL0516",
    "size_is of something that is no pointer",
    Severity.ERROR,
    """
An attribute or variable with `size_is` is a pointer. tecsgen: S1011, S1048 and T1003.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { [size_is( 2 )] int32_t values = 1; }; };
```
""",
)

SIZED_INITIALISER = Rule(
    "CDL0517",
    "initialiser that does not fit size_is",
    Severity.ERROR,
    """
What has `size_is` takes `{ ... }`, with no more values than the size. tecsgen: S1012, S1013,
S1050, S1051, S1168.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { [size_is( 2 )] int32_t *values = { 1, 2, 3 }; }; };
```
""",
)

UNSIZED_INITIALISER = Rule(
    "CDL0518",
    "list for a pointer without size_is",
    Severity.ERROR,
    """
A pointer takes `{ ... }` if `size_is` tells how many there are. tecsgen: S1159, S1169 and T9999.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t *values = { 1, 2, 3 }; }; };
```
""",
)

SIZE_NOT_CONSTANT = Rule(
    "CDL0519",
    "size_is that is not known",
    Severity.ERROR,
    """
The size of an attribute or variable is known for each cell: it is made of constants and
attributes. tecsgen: S1049.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t n; [size_is( n )] int32_t *values; }; };
cell tWorker Worker { n = C_EXP( "COUNT" ); values = { 1 }; };
```
""",
)

OPEN_ARRAY = Rule(
    "CDL0520",
    "array without a size",
    Severity.ERROR,
    """
An array has a size, except an attribute with `omit`. tecsgen: S2004, S2005.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t values[] = { 1, 2 }; }; };
```
""",
)

NO_ENTRY = Rule(
    "CDL0521",
    "celltype that nobody can call",
    Severity.WARNING,
    """
A celltype that is not `active`, and has no entry port and no factory, never runs. tecsgen: W1002.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { call sWork cWork; };
```
""",
)

ALLOCATOR_FORM = Rule(
    "CDL0522",
    "allocator of another form",
    Severity.ERROR,
    """
In a celltype an allocator is passed on: `[allocator( func.par <= cCall.func.par )]`; in a
composite it can be an entry port of its own: `[allocator( func.par = eAlloc )]`. A cell names a
cell: `[allocator( ePort.func.par = Alloc.eAlloc )]`. tecsgen: S1081, S1086, S1174, S1176.

```cdl
// gives this finding
signature sAlloc { void *alloc( [in] int32_t size ); };
signature sWork { void work( [send( sAlloc ), size_is( n )] uint8_t *data, [in] int32_t n ); };
celltype tWorker { [allocator( work.data = eWork )] entry sWork eWork; };
```
""",
)

ALLOCATOR_NAME = Rule(
    "CDL0523",
    "unknown name in an allocator",
    Severity.ERROR,
    """
An allocator names a function of the signature, a parameter of it and, behind `<=`, a call port.
tecsgen: S1082, S1083, S1087, S1088, S1091, S1175.

```cdl
// gives this finding
signature sWork { void work( [in] int32_t n ); };
celltype tWorker { [allocator( wrok.n <= cWork.work.n )] entry sWork eWork; call sWork cWork; };
```
""",
)

ALLOCATOR_DIRECTION = Rule(
    "CDL0524",
    "allocator of a parameter that needs none",
    Severity.ERROR,
    """
Only `send` and `receive` parameters have an allocator; one that is passed on has the same
direction on both sides. tecsgen: S1084, S1089, S1090.

```cdl
// gives this finding
signature sWork { void work( [in] int32_t n ); };
celltype tWorker { [allocator( work.n <= cWork.work.n )] entry sWork eWork; call sWork cWork; };
```
""",
)

ALLOCATOR_TWICE = Rule(
    "CDL0525",
    "two allocators for one parameter",
    Severity.ERROR,
    """
Each parameter has one allocator. tecsgen: S1085.

```cdl
// gives this finding
signature sAlloc {
  ER alloc( [in] int32_t size, [out] void **p );
  ER dealloc( [in] const void *p );
};
signature sWork { ER work( [send( sAlloc ), size_is( n )] uint8_t *data, [in] int32_t n ); };
celltype tWorker {
  [allocator( work.data <= cWork.work.data, work.data <= cWork.work.data )] entry sWork eWork;
  call sWork cWork;
};
```
""",
)

NOT_EXPORTED = Rule(
    "CDL0530",
    "port or attribute of a composite that is not connected",
    Severity.ERROR,
    """
Each port and attribute of a composite stands for one of an inner cell. tecsgen: S1056.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
composite tBox { entry sWork eWork; cell tWorker Inner {}; };
```
""",
)

NOT_DECLARED = Rule(
    "CDL0531",
    "exported name that the composite does not declare",
    Severity.ERROR,
    """
What an inner cell gives to the outside is declared in the composite, too. tecsgen: S1062.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
composite tBox { cell tWorker Inner {}; composite.eWork => Inner.eWork; };
```
""",
)

UNKNOWN_INNER_CELL = Rule(
    "CDL0532",
    "inner cell not found",
    Severity.ERROR,
    """
`composite.eName => Cell.eName;` names a cell of the composite that stands before it. tecsgen:
S1057.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
composite tBox { entry sWork eWork; cell tWorker Inner {}; composite.eWork => Other.eWork; };
```
""",
)

UNKNOWN_INNER_NAME = Rule(
    "CDL0533",
    "inner cell has no such port or attribute",
    Severity.ERROR,
    """
What is exported is a port or attribute of the inner cell. tecsgen: S1061.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
composite tBox { entry sWork eWork; cell tWorker Inner {}; composite.eWork => Inner.eOther; };
```
""",
)

EXPORT_KIND = Rule(
    "CDL0534",
    "exported as something else",
    Severity.ERROR,
    """
A call port is exported as call port (`cIn => composite.cOut` in the cell), an entry port as entry
port (`composite.eOut => Cell.eIn`), an attribute as attribute (`name = composite.name`); a
variable not at all. tecsgen: S1058, S1059, S1060, S1063, S1065, S1069.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; call sWork cWork; };
composite tBox { entry sWork eWork; cell tWorker Inner { cWork => composite.eWork; }; };
```
""",
)

EXPORT_MISMATCH = Rule(
    "CDL0535",
    "exported with another type",
    Severity.ERROR,
    """
Signature, size, `optional`, `omit`, `dynamic`, `ref_desc` of a port, and the type of an attribute
are the same inside and outside. Types are compared as they are written. tecsgen: S1064, S1066,
S1067, S1068, S9999.

```cdl
// gives this finding
signature sA {};
signature sB {};
celltype tWorker { entry sA eWork; };
composite tBox { entry sB eWork; cell tWorker Inner {}; composite.eWork => Inner.eWork; };
```
""",
)

COMPOSITE_SINGLETON = Rule(
    "CDL0536",
    "composite of a singleton is no singleton",
    Severity.ERROR,
    """
A composite with an inner cell of a singleton is `singleton`. tecsgen: S1053.

```cdl
// gives this finding
signature sWork {};
[singleton] celltype tWorker { entry sWork eWork; };
composite tBox { entry sWork eWork; cell tWorker Inner {}; composite.eWork => Inner.eWork; };
```
""",
)

NO_SINGLETON_INSIDE = Rule(
    "CDL0537",
    "singleton without a singleton inside",
    Severity.WARNING,
    """
A composite is said to be `singleton`, but no inner cell is. tecsgen: W1004.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
[singleton] composite tBox {
  entry sWork eWork;
  cell tWorker Inner {};
  composite.eWork => Inner.eWork;
};
```
""",
)

COMPOSITE_ACTIVE = Rule(
    "CDL0538",
    "composite and inner cells differ in active",
    Severity.ERROR,
    """
A composite is `active` if and only if an inner cell is. tecsgen: S1054, S1055.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
[active] composite tBox {
  entry sWork eWork;
  cell tWorker Inner {};
  composite.eWork => Inner.eWork;
};
```
""",
)

JOINED_AND_EXPORTED = Rule(
    "CDL0539",
    "call port joined and exported",
    Severity.ERROR,
    """
A call port of an inner cell is either joined inside or exported. tecsgen: S1131.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; call sWork cWork; };
composite tBox {
  call sWork cWork;
  cell tWorker One { cWork = One.eWork; cWork => composite.cWork; };
};
```
""",
)

INNER_EXPRESSION = Rule(
    "CDL0540",
    "computed value of an inner attribute",
    Severity.ERROR,
    """
The attribute of an inner cell is a constant or `composite.name`, nothing that is computed from
attributes. tecsgen: S1033.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t number; }; };
composite tBox {
  entry sWork eWork;
  attr { int32_t number; };
  cell tWorker Inner { number = number + 1; };
  composite.eWork => Inner.eWork;
};
```
""",
)

INNER_NAME = Rule(
    "CDL0541",
    "name of the inner cell where one of the composite is meant",
    Severity.ERROR,
    """
Where a name belongs to the inner cell, too, `composite.` tells that the one outside is meant.
tecsgen: S1034, S1036.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; call sWork cWork; };
composite tBox { call sWork cWork; cell tWorker Inner { cWork => cWork; }; };
```
""",
)

OUTSIDE_COMPOSITE = Rule(
    "CDL0542",
    "composite. where there is none",
    Severity.ERROR,
    """
`composite.name` is for inner cells of a composite, as the value of an attribute; a call port is
exported by `=>`. tecsgen: S1035, S1107.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t number; }; };
cell tWorker Worker { number = composite.number; };
```
""",
)

THROUGH_INSIDE = Rule(
    "CDL0543",
    "through in a composite",
    Severity.ERROR,
    """
A join inside a composite has no plug-ins. tecsgen: S1177.

```cdl
// gives this finding
signature sWork { void work( void ); };
celltype tWorker { entry sWork eWork; };
[active] celltype tUser { call sWork cWork; };
[active] composite tBox {
  cell tWorker Worker {};
  cell tUser User { [through( TracePlugin, "" )] cWork = Worker.eWork; };
};
```
""",
)

SIZED_EXPORT = Rule(
    "CDL0544",
    "size_is inside and outside a composite",
    Severity.ERROR,
    """
If an attribute has `size_is`, the one of the composite has it, too, and the attributes in it are
exported. tecsgen: S1170, S1171, S1172.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t n; [size_is( n )] int32_t *values; }; };
composite tBox {
  entry sWork eWork;
  attr { int32_t n; int32_t *values; };
  cell tWorker Inner { n = composite.n; values = composite.values; };
  composite.eWork => Inner.eWork;
};
```
""",
)

NO_EFFECT_ON_COMPOSITE = Rule(
    "CDL0545",
    "idx_is_id of a composite",
    Severity.WARNING,
    """
`idx_is_id` is a matter of the inner celltypes; for a composite it has no effect. tecsgen: W1005.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; };
[idx_is_id] composite tBox {
  entry sWork eWork;
  cell tWorker Inner {};
  composite.eWork => Inner.eWork;
};
```
""",
)

ALLOCATOR_MISMATCH = Rule(
    "CDL0546",
    "another allocator inside than outside",
    Severity.ERROR,
    """
The allocator that a composite names for its entry port is the one that the inner cell uses.
tecsgen: S1173.

```cdl
// gives this finding
signature sAlloc {
  ER alloc( [in] int32_t size, [out] void **p );
  ER dealloc( [in] const void *p );
};
signature sWork { ER work( [send( sAlloc ), size_is( n )] uint8_t *data, [in] int32_t n ); };
celltype tAlloc { entry sAlloc eAlloc; };
celltype tWorker { entry sWork eWork; };
composite tBox {
  [allocator( work.data = eAlloc )] entry sWork eWork;
  entry sAlloc eAlloc;
  cell tAlloc Outer {};
  cell tAlloc Hidden {};
  [allocator( eWork.work.data = Hidden.eAlloc )] cell tWorker Inner {};
  composite.eWork => Inner.eWork;
  composite.eAlloc => Outer.eAlloc;
};
```
""",
)

FACTORY_FORMAT = Rule(
    "CDL0547",
    "format that does not fit its values",
    Severity.ERROR,
    """
The format of `write` has more places than there are values, a place that is none, or one for
numbers where a string or `true` and `false` stand: use `%s` for these. tecsgen fails when it
writes.

```cdl
// gives this finding
signature sWork {};
celltype tWorker { entry sWork eWork; attr { int32_t n = 1; };
  factory { write( "a.cfg", "%d %d", n ); }; };
```
""",
)

RULES: tuple[Rule, ...] = (
    UNKNOWN_SIGNATURE,
    NOT_A_SIGNATURE,
    BAD_PORT_SIZE,
    PORT_SPECIFIER,
    SPECIFIERS_CLASH,
    SPECIFIER_TWICE,
    NAME_TWICE,
    BAD_FIXED_JOIN,
    UNKNOWN_REQUIRED,
    REQUIRED_NOT_SINGLETON,
    REQUIRED_NOT_ENTRY,
    REQUIRE_CLASH,
    UNKNOWN_FACTORY_FUNCTION,
    FACTORY_TEXT,
    FACTORY_ARGUMENT,
    FACTORY_FORMAT,
    SIZE_IS_OF_NO_POINTER,
    SIZED_INITIALISER,
    UNSIZED_INITIALISER,
    SIZE_NOT_CONSTANT,
    OPEN_ARRAY,
    NO_ENTRY,
    ALLOCATOR_FORM,
    ALLOCATOR_NAME,
    ALLOCATOR_DIRECTION,
    ALLOCATOR_TWICE,
    NOT_EXPORTED,
    NOT_DECLARED,
    UNKNOWN_INNER_CELL,
    UNKNOWN_INNER_NAME,
    EXPORT_KIND,
    EXPORT_MISMATCH,
    COMPOSITE_SINGLETON,
    NO_SINGLETON_INSIDE,
    COMPOSITE_ACTIVE,
    JOINED_AND_EXPORTED,
    INNER_EXPRESSION,
    INNER_NAME,
    OUTSIDE_COMPOSITE,
    THROUGH_INSIDE,
    SIZED_EXPORT,
    NO_EFFECT_ON_COMPOSITE,
    ALLOCATOR_MISMATCH,
)
