"""Rules about files and what they hold together (CDL00xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

MISSING_FILE = Rule(
    "CDL0001",
    "file not found",
    Severity.ERROR,
    """
A CDL file that was given on the command line, or named in `rtgen.toml`, does not exist.
""",
)

UNREADABLE = Rule(
    "CDL0002",
    "file cannot be read",
    Severity.ERROR,
    """
The file is there, but the system does not let it be read: look at its permissions.
""",
)

BINARY = Rule(
    "CDL0003",
    "not a text file",
    Severity.ERROR,
    """
A CDL file is text in UTF-8, EUC-JP or Shift_JIS. This one holds a NUL byte, as UTF-16 text and
binary files do.
""",
)

TOO_LARGE = Rule(
    "CDL0004",
    "file too large",
    Severity.ERROR,
    """
Files of more than 32 MiB are not read.
""",
)

ENCODING = Rule(
    "CDL0005",
    "doubtful encoding",
    Severity.WARNING,
    """
The bytes of the file do not fit the encoding that was asked for, or none of UTF-8, EUC-JP and
Shift_JIS. Without a choice rtgen looks at the bytes: a file is UTF-8 if it can be, else EUC-JP or
Shift_JIS, whichever gives more likely text. `--kcode euc`, `sjis`, `utf8` or `none`, or
`[sources] kcode` in `rtgen.toml`, decides.
""",
)

IMPORT_MISSING = Rule(
    "CDL0006",
    "imported file not found",
    Severity.ERROR,
    """
What `import` names is neither a path from the working folder nor below one of the folders
of `-I` (or `[sources] include`), nor beside the file that imports it. tecsgen: S1148.

```cdl
import( "motor_signatures.cdl" );   // rtgen check -I cdl/common board.cdl
```
""",
)

KERNEL_MISSING = Rule(
    "CDL0007",
    "kernel file not found",
    Severity.WARNING,
    """
A CDL file or a C header of the kernel or of the TECS distribution is not there, as is usual on a
PC. The kernel's scalar types (`ER`, `ID`, `int_t`, ...) are known without it. tecsgen stops here
(S1148, S1142); rtgen goes on, and calls it an error only where something else is wrong, which is
then likely to come from it.

```cdl
import( <kernel.cdl> );
signature sMotor { ER stop( void ); };   // ER is known all the same
```
""",
)

IMPORT_FORM = Rule(
    "CDL0008",
    "file imported in both forms",
    Severity.WARNING,
    """
`import( <file> )` marks what it reads as reused, so that no templates are made for it;
`import( "file" )` does not. A file is read once, in the form that came first. tecsgen: W1008.

```cdl
import( <motor.cdl> );
import( "motor.cdl" );   // has no effect
```
""",
)

PRELUDE = Rule(
    "CDL0009",
    "kernel types known without an import",
    Severity.NOTE,
    """
The file uses types such as `ER` or `int_t` that a C header of the kernel declares, but imports no
such header. rtgen knows them; tecsgen does not, and needs an `import` or `import_C` for the same
file. `--prelude none`, or `prelude = "none"` in `[sources]` of `rtgen.toml`, makes rtgen as strict.

```cdl
import_C( "tecs.h" );
signature sMotor { ER stop( void ); };
```
""",
)

TOO_MANY = Rule(
    "CDL0010",
    "too many findings",
    Severity.ERROR,
    """
A run shows 1000 findings of each severity at most.
""",
)

SAME_STEM = Rule(
    "CDL0011",
    "two CDL files of one name",
    Severity.ERROR,
    """
What is generated for a CDL file goes into a folder of its name without the suffix, so two files
of a project cannot share it. Rename one.
""",
)

IMPORT_DEPTH = Rule(
    "CDL0012",
    "imports nested too deeply",
    Severity.ERROR,
    """
Files import files for more than 100 levels.
""",
)

RULES = (
    MISSING_FILE,
    UNREADABLE,
    BINARY,
    TOO_LARGE,
    ENCODING,
    IMPORT_MISSING,
    KERNEL_MISSING,
    IMPORT_FORM,
    PRELUDE,
    TOO_MANY,
    SAME_STEM,
    IMPORT_DEPTH,
)
