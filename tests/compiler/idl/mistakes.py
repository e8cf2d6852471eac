"""The commonest mistakes, by name: each gives one message, at the position marked §, and a hint.

Two files are in the folder of each definition: `wheel.idl`, which declares Wheel, and `axle.idl`,
whose last `;` is missing.
"""

from mistake import Mistake
from mistakes_of_constants import CONSTANTS
from mistakes_of_files import FILES
from mistakes_of_interfaces import INTERFACES
from mistakes_of_names import NAMES
from mistakes_of_punctuation import PUNCTUATION
from mistakes_of_spelling import SPELLING
from mistakes_of_structs import STRUCTS
from mistakes_of_types import TYPES

GROUPS = (
    PUNCTUATION,
    SPELLING,
    FILES,
    CONSTANTS,
    TYPES,
    STRUCTS,
    INTERFACES,
    NAMES,
)
MISTAKES: dict[str, Mistake] = {
    name: mistake for group in GROUPS for name, mistake in group.items()
}
