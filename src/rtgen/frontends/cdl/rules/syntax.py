"""Rules of syntax (CDL02xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNEXPECTED = Rule(
    "CDL0200",
    "syntax error",
    Severity.ERROR,
    """
The text does not follow the grammar of CDL at this place. Where only few things could have stood
here, the message names them. The broken statement is passed over and reading goes on behind it, so
other mistakes are told in the same run. tecsgen: G1016.

```cdl
cell tMotor { };            // wrong: the cell has no name
cell tMotor Motor { };      // right
```
""",
)

MISSING_SEMICOLON = Rule(
    "CDL0201",
    "missing semicolon",
    Severity.ERROR,
    """
Every statement ends with `;`, also behind a closing brace, and so does every function, port and
join. tecsgen: G1016.

```cdl
signature sMotor { ER stop( void ); }    // wrong
signature sMotor { ER stop( void ); };   // right
```
""",
)

MISSPELT_KEYWORD = Rule(
    "CDL0202",
    "misspelt keyword",
    Severity.ERROR,
    """
A word stands where only a keyword can, and it is like one. tecsgen: G1016.

```cdl
signatur sMotor { ER stop( void ); };    // wrong
signature sMotor { ER stop( void ); };   // right
```
""",
)

KEYWORD_AS_NAME = Rule(
    "CDL0203",
    "keyword used as a name",
    Severity.ERROR,
    """
A reserved word cannot name anything. Specifiers (`in`, `string`, `size_is`, ...) are reserved in
brackets only, so they may be names, but not of something that a bracket speaks of. tecsgen: G1016.

```cdl
attr { int32_t call; };     // wrong
attr { int32_t calls; };    // right
```
""",
)

TYPE_AS_NAME = Rule(
    "CDL0204",
    "type used as a name",
    Severity.ERROR,
    """
A typedef's name is a type wherever it stands in its name space: nothing else can be called so, and
it cannot be declared again. tecsgen: G1016.

```cdl
typedef int32_t Speed;
attr { int32_t Speed; };    // wrong
attr { Speed speed; };      // right
```
""",
)

UNCLOSED_BRACE = Rule(
    "CDL0205",
    "brace that is never closed",
    Severity.ERROR,
    """
The file ends, but a `{` is still open. The place shown is the innermost such brace.
tecsgen: G1015.
""",
)

STRAY_BRACE = Rule(
    "CDL0206",
    "brace that closes nothing",
    Severity.ERROR,
    """
A `}` stands where no brace is open. Remove it, or look for the missing `{` before it.
tecsgen: G1016.
""",
)

UNEXPECTED_END = Rule(
    "CDL0207",
    "file ends too early",
    Severity.ERROR,
    """
The file ends in the middle of a statement. tecsgen: G1015.
""",
)

EMPTY_BLOCK = Rule(
    "CDL0208",
    "block without content",
    Severity.ERROR,
    """
A name space, a struct, a celltype, a composite and the blocks `attr` and `var` hold at least one
entry. Signatures, regions, cells and factories may be empty. tecsgen: G1016.

```cdl
celltype tMotor { attr { }; entry sMotor eMotor; };   // wrong
celltype tMotor { entry sMotor eMotor; };             // right
```
""",
)

EXTRA_SEMICOLON = Rule(
    "CDL0209",
    "semicolon too many",
    Severity.ERROR,
    """
A `;` ends a statement; there is no empty statement. tecsgen: G1016.

```cdl
signature sMotor { ER stop( void ); };;   // wrong
```
""",
)

TOO_MANY = Rule(
    "CDL0210",
    "too many syntax errors",
    Severity.ERROR,
    """
After 50 syntax errors the rest of a file is not read: likely it is no CDL.
""",
)

TOO_DEEP = Rule(
    "CDL0211",
    "nested too deeply",
    Severity.ERROR,
    """
Parentheses, braces and operators are nested for some hundred levels. rtgen does not read that.
""",
)

MISSING_MARK = Rule(
    "CDL0212",
    "missing mark",
    Severity.ERROR,
    """
A comma, a parenthesis, a bracket or an equals sign is missing. tecsgen: G1016.

```cdl
ER set( [in] int32_t speed;      // wrong
ER set( [in] int32_t speed );    // right
```
""",
)

QUALIFIER = Rule(
    "CDL0213",
    "qualifier behind the type",
    Severity.ERROR,
    """
`const` and `volatile` stand before the type, or behind a `*`; a parameter has one of them at most.
tecsgen: G1016.

```cdl
ER put( [in,size_is(n)] int8_t const *p, [in] int32_t n );    // wrong
ER put( [in,size_is(n)] const int8_t *p, [in] int32_t n );    // right
```
""",
)

MISPLACED_SPECIFIER = Rule(
    "CDL0214",
    "specifier that cannot stand here",
    Severity.ERROR,
    """
Each specifier belongs to some kinds of statement only. tecsgen: G1009, G1012, G1013, G1016.

| before | specifiers |
|---|---|
| signature | `context` `callback` `deviate` `generate` |
| function | `oneway` |
| parameter | `in` `out` `inout` `send` `receive` `size_is` `count_is` `string` `nullable` |
| struct member | `size_is` `count_is` `string` |
| celltype | `singleton` `active` `idx_is_id` `generate` |
| composite | `singleton` `active` `idx_is_id` `generate` |
| call port | `optional` `omit` `dynamic` `ref_desc` |
| entry port | `inline` `allocator` |
| attribute | `omit` `size_is` `choice` |
| variable | `size_is` |
| cell | `allocator` `id` `prototype` `restrict` `generate` |
| join | `through` |
| region | `linkunit` `node` `class` `domain` `in_through` `out_through` `to_through` |

```cdl
[oneway] signature sMotor { void stop( void ); };   // wrong
signature sMotor { [oneway] void stop( void ); };   // right
```
""",
)

UNKNOWN_SPECIFIER = Rule(
    "CDL0215",
    "unknown specifier",
    Severity.ERROR,
    """
A bracket holds specifiers, separated by commas, and this word is none. tecsgen: G1016.

```cdl
ER get( [output] int32_t *speed );   // wrong
ER get( [out] int32_t *speed );      // right
```
""",
)

RULES = (
    UNEXPECTED,
    MISSING_SEMICOLON,
    MISSPELT_KEYWORD,
    KEYWORD_AS_NAME,
    TYPE_AS_NAME,
    UNCLOSED_BRACE,
    STRAY_BRACE,
    UNEXPECTED_END,
    EMPTY_BLOCK,
    EXTRA_SEMICOLON,
    TOO_MANY,
    TOO_DEEP,
    MISSING_MARK,
    QUALIFIER,
    MISPLACED_SPECIFIER,
    UNKNOWN_SPECIFIER,
)
