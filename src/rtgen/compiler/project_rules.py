"""The rules of the project file, the output folder (codes PRJ...) and the environment (ENV...)."""

from __future__ import annotations

from rtgen.compiler.diagnostics import Rule, Severity, rules_of

FILE_UNREADABLE = Rule("PRJ0001", "rtgen.toml cannot be read", Severity.ERROR)
UNKNOWN_KEY = Rule("PRJ0002", "unknown section or key", Severity.ERROR)
WRONG_TYPE = Rule("PRJ0003", "value of the wrong kind", Severity.ERROR)
PROJECT_NAME = Rule("PRJ0004", "name that Python cannot import", Severity.ERROR)
PATH_MISSING = Rule("PRJ0005", "path that does not exist", Severity.ERROR)
PATH_OVERLAP = Rule("PRJ0006", "folders in each other's way", Severity.ERROR)
SOURCE_NONE = Rule("PRJ0007", "nothing to read", Severity.ERROR)
SOURCE_KIND = Rule("PRJ0008", "file of an unknown kind", Severity.ERROR)
UNKNOWN_CODE = Rule("PRJ0009", "code that no rule has", Severity.ERROR)
OTHER_FORM = Rule("PRJ0010", "unknown form", Severity.ERROR)
WHICH_COMPONENT = Rule("PRJ0011", "not one component", Severity.ERROR)
LEFTOVER_SKELETON = Rule(
    "PRJ0012", "behaviour of a component that is not defined", Severity.WARNING
)
UNKNOWN_NAME = Rule("PRJ0013", "name that is not in the definition", Severity.WARNING)
MISSPELT_CALLBACK = Rule("PRJ0014", "misspelt callback", Severity.WARNING)
NO_PATH = Rule("PRJ0015", "path that no file can have", Severity.ERROR)
UNKNOWN_TEMPLATE = Rule("PRJ0016", "template that rtgen does not have", Severity.ERROR)
STALE_FILE = Rule("PRJ0017", "generated file that is out of date", Severity.ERROR)
STRAY_FILE = Rule(
    "PRJ0018",
    "file in the output folder that rtgen does not generate",
    Severity.WARNING,
)
RUN_CONFLICT = Rule(
    "PRJ0019", "values of [run] that exclude each other", Severity.ERROR
)
CHANGED_INPUTS = Rule(
    "PRJ0020", "definitions that changed after their files", Severity.WARNING
)
NO_PLUGIN = Rule(
    "PRJ0021", "options of a plug-in that is not installed", Severity.WARNING
)
NO_RENAME = Rule("PRJ0022", "rename that cannot be done", Severity.ERROR)
NOT_FOLLOWED = Rule("PRJ0023", "use that a rename did not follow", Severity.WARNING)
NOT_PYTHON = Rule("PRJ0024", "behaviour that Python cannot read", Severity.ERROR)
NO_BEHAVIOUR = Rule("PRJ0025", "component without a behaviour", Severity.WARNING)
NO_ANSWER = Rule("PRJ0026", "callback without a return code", Severity.WARNING)
INTERRUPTED = Rule("PRJ0027", "rename that was interrupted", Severity.WARNING)
SAME_PATH = Rule("PRJ0101", "two files of one name", Severity.ERROR)
LEAVES_OUTPUT = Rule("PRJ0102", "file outside the output folder", Severity.ERROR)
LINK_IN_OUTPUT = Rule("PRJ0103", "link in the output folder", Severity.ERROR)
ENCODING = Rule("PRJ0104", "text that is not Unicode", Severity.ERROR)
NAME_TOO_LONG = Rule("PRJ0105", "file name too long", Severity.ERROR)
FOREIGN_FILE = Rule("PRJ0106", "file not owned by rtgen", Severity.ERROR)
ENVIRONMENT = Rule("ENV0001", "the environment failed", Severity.ERROR)
SUPERVISED = Rule("ENV0002", "node has an SDO client already", Severity.WARNING)
NO_PAGE = Rule("ENV0003", "installation without the page", Severity.WARNING)

RULES = rules_of(globals())
