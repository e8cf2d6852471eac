"""Limits on what definitions may require, beyond those of single files and of their syntax.

They are far above what people write, and bound every stage to seconds and 500 megabytes.
"""

MAX_LEVELS = 100
"""Maximum length of a chain of declarations that refer to each other by types, members or bases."""

MAX_NESTING = 256
"""Maximum depth of blocks, brackets and inclusions in the text of a file."""

MAX_VALUES = 5_000
"""Maximum number of values in a struct of a TECS signature, including those of nested structs."""

MAX_VARIABLES = 15_000
"""Maximum number of variables of a CANopen device that counts stand for, as of compact objects."""

MAX_WRITTEN_VARIABLES = 60_000
"""Maximum number of variables of a CANopen device."""
