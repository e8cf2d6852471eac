"""The limits of what definitions may ask for, beyond those of single files and of their syntax.

They are far above what people write, and keep every stage within seconds and 500 megabytes.
"""

MOST_LEVELS = 100
"""The longest way from one declaration to the next through types, members and bases."""

MOST_VALUES = 5_000
"""The values that a struct of a TECS signature has in place, those of inner structs included."""

MOST_VARIABLES = 15_000
"""The variables that the objects of a CANopen device have in all, compact ones included."""
