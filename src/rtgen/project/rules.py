"""The rules of the project file, the output folder (codes PRJ...) and the environment (ENV...)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

FILE_UNREADABLE = Rule(
    "PRJ0001",
    "rtgen.toml cannot be read",
    Severity.ERROR,
    """
`rtgen.toml` is not TOML 1.0 in UTF-8, so nothing in it can be used.

```toml
[sources]
paths = ["idl"          # the closing bracket is missing
```

Correct the place that the message names.
""",
)

UNKNOWN_KEY = Rule(
    "PRJ0002",
    "unknown section or key",
    Severity.ERROR,
    """
`rtgen.toml` holds a section or a key that rtgen does not know. It is refused rather than passed
over, since a misspelt key would otherwise do nothing without a word.

```toml
[output]
pakage = "robots"       # did you mean 'package'?
```

Sections: `[sources] paths include define`, `[output] dir skeletons package target`,
`[components]`, `[adapter.NAME]`, `[lint] ignore select`.
""",
)

WRONG_TYPE = Rule(
    "PRJ0003",
    "value of the wrong kind",
    Severity.ERROR,
    """
A key of `rtgen.toml` has a value of another kind than it takes.

```toml
[sources]
paths = "idl"           # wrong: a string
paths = ["idl"]         # right: a list of strings
```
""",
)

PROJECT_NAME = Rule(
    "PRJ0004",
    "name that Python cannot import",
    Severity.ERROR,
    """
`package` in `[output]`, and the last part of `skeletons`, become Python packages. So they must be
identifiers, differ from each other, and not hide a module that others need: `generated`, `RTC`
(OpenRTM-aist's), `rtgen` or a module of the standard library.

```toml
[output]
package = "my-robots"   # wrong
package = "my_robots"   # right
```
""",
)

PATH_MISSING = Rule(
    "PRJ0005",
    "path that is not there",
    Severity.ERROR,
    """
A path in `[sources]` of `rtgen.toml` names no file or folder. Paths are relative to the folder
of `rtgen.toml`.
""",
)

PATH_OVERLAP = Rule(
    "PRJ0006",
    "folders in each other's way",
    Severity.ERROR,
    """
rtgen owns its output folder: it overwrites and removes files there. So the output folder must lie
below the project's folder, and must not hold what a user writes: definitions or skeletons.

```toml
[output]
dir = "."               # wrong: the whole project would be rtgen's
dir = "generated"       # right
```
""",
)

SOURCE_NONE = Rule(
    "PRJ0007",
    "nothing to read",
    Severity.ERROR,
    """
No definition file was named, and no `rtgen.toml` that names some was found in this folder or in
one above it; or the folders named hold no definition file.

```toml
[sources]
paths = ["idl"]
```
""",
)

SOURCE_KIND = Rule(
    "PRJ0008",
    "file of an unknown kind",
    Severity.ERROR,
    """
A path was given that does not end like a definition file. The kind of a file is told by its
suffix: `.idl` for OMG IDL; `.cdl` for TECS; `.eds` and `.dcf` for CANopen devices; `.xml` for a
component (RtcProfile), or for a system (RtsProfile), where a command takes one: `generate` and
`check` do for the target `openrtm`.
""",
)

UNKNOWN_CODE = Rule(
    "PRJ0009",
    "code that no rule has",
    Severity.ERROR,
    """
`[lint] ignore`, `[lint] select` and the options of the same names take codes of rules, as findings
show them. A misspelt code would silence nothing without a word.

```toml
[lint]
ignore = ["LINT0003"]
```

`rtgen explain` lists all codes.
""",
)

OTHER_FORM = Rule(
    "PRJ0010",
    "no such form",
    Severity.ERROR,
    """
`rtgen convert` writes components as IDL or RtcProfile, and systems as RtsProfile, each profile as
XML or YAML. A system cannot become a component, nor the other way round.
""",
)

WHICH_COMPONENT = Rule(
    "PRJ0011",
    "not one component",
    Severity.ERROR,
    """
The file defines no component, several of which none was named by `--component`, or not the named
one.
""",
)

LEFTOVER_SKELETON = Rule(
    "PRJ0012",
    "behaviour of a component that is not defined",
    Severity.WARNING,
    """
A module beside the skeletons imports the base of a component that no definition has (any more):
the component was renamed or removed, and its behaviour stayed behind. rtgen never touches it.

```python
from myrobot.components.swing import SwingBase      # the component is called Pendulum now
```

Move what is in it to the new skeleton, or change the import and the name of the class; then
remove the old file. `rtgen generate` and `rtgen check` report it.
""",
)

UNKNOWN_PORT = Rule(
    "PRJ0013",
    "port that the definition lacks",
    Severity.WARNING,
    """
A behaviour reads or writes a port that its component's definition does not have (any more), as
after a port was renamed. It would fail at run time only.

```python
self.temprature.write(Temperature(20.0))            # the port is called temperature
```

Modules beside the skeletons are looked at whose class derives from the generated base alone.
`rtgen generate` and `rtgen check` report it.
""",
)

SAME_PATH = Rule(
    "PRJ0101",
    "two files of one name",
    Severity.ERROR,
    """
Two definitions would be generated into the same file, into files that differ only in upper and
lower case (one file on Windows and macOS), or a file would stand where another needs a folder.
Rename one of the definitions, or give one of the input files another name.
""",
)

LEAVES_OUTPUT = Rule(
    "PRJ0102",
    "file outside the output folder",
    Severity.ERROR,
    """
A generated file would lie outside the output folder, because a name in a definition or in a
back end holds `..`, a slash, or another part that file systems treat specially. rtgen writes
below its output folder (and, for skeletons, below the skeleton folder) only.
""",
)

LINK_IN_OUTPUT = Rule(
    "PRJ0103",
    "link in the output folder",
    Severity.ERROR,
    """
A symbolic link stands where rtgen would write, so writing could change files outside the output
folder, or one file by two names. Remove the link; rtgen makes the folders and files it needs. The
output folder itself may be a link only if it stays below the project's folder (or `-o DIR`).
""",
)

ENCODING = Rule(
    "PRJ0104",
    "text that is not Unicode",
    Severity.ERROR,
    """
A generated file would hold a lone surrogate, which UTF-8 cannot express. It comes from a name or
text in a definition or from a back end.
""",
)

NAME_TOO_LONG = Rule(
    "PRJ0105",
    "file name too long",
    Severity.ERROR,
    """
A name in a definition gives a file or folder name of more than 255 bytes, which no usual file
system takes. Shorten the name.
""",
)

FOREIGN_FILE = Rule(
    "PRJ0106",
    "file of somebody else",
    Severity.ERROR,
    """
A generated file would overwrite a file that rtgen did not make: neither does the manifest
`.rtgen.json` name it, nor does it begin with "Generated by rtgen". This happens where the output
folder was there before, with other content:

```toml
[output]
dir = "lib"             # holds lib/robots/__init__.py, written by hand
```

Nothing was written. Choose another output folder, or another `package`; or move the file away.
""",
)

ENVIRONMENT = Rule(
    "ENV0001",
    "the environment failed",
    Severity.ERROR,
    """
The definitions are not to blame: a file cannot be read or written, an extra is not installed, a
plug-in cannot be loaded, or a target is not part of this version. The command ends with 3.
""",
)

SUPERVISED = Rule(
    "ENV0002",
    "node has an SDO client already",
    Severity.WARNING,
    """
A node's SDO server talks to one client: the manager of its network, or the process of its proxy.
When `rtgen can sdo` reads or writes beside it, answers of the one can be taken for those of the
other, and transfers of both can fail.

Use the SDO port of the node's proxy, or do it while no manager runs.
""",
)

RULES: tuple[Rule, ...] = (
    FILE_UNREADABLE,
    UNKNOWN_KEY,
    WRONG_TYPE,
    PROJECT_NAME,
    PATH_MISSING,
    PATH_OVERLAP,
    SOURCE_NONE,
    SOURCE_KIND,
    UNKNOWN_CODE,
    OTHER_FORM,
    WHICH_COMPONENT,
    LEFTOVER_SKELETON,
    UNKNOWN_PORT,
    SAME_PATH,
    LEAVES_OUTPUT,
    LINK_IN_OUTPUT,
    ENCODING,
    NAME_TOO_LONG,
    FOREIGN_FILE,
    ENVIRONMENT,
    SUPERVISED,
)
