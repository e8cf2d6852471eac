"""Names of the types of configuration parameters in profiles and in OpenRTM: words of C++.

Source: the output of RTCBuilder (facts on `rtc:Configuration`), and variants used by people.
"""

from __future__ import annotations

import re
from typing import Final

STRING: Final = "string"
CANONICAL: Final = {
    "short": "short",
    "short int": "short",
    "unsigned short": "unsigned short",
    "unsigned short int": "unsigned short",
    "int": "long",
    "long": "long",
    "long int": "long",
    "unsigned": "unsigned long",
    "unsigned int": "unsigned long",
    "unsigned long": "unsigned long",
    "unsigned long int": "unsigned long",
    "long long": "long long",
    "long long int": "long long",
    "unsigned long long": "unsigned long long",
    "unsigned long long int": "unsigned long long",
    "float": "float",
    "double": "double",
    "bool": "boolean",
    "boolean": "boolean",
    "octet": "octet",
    "unsigned char": "octet",
    **dict.fromkeys(
        ("string", "std::string", "char*", "const char*", "char", "str"), STRING
    ),
}
"""The types of IDL by their words."""
_VECTOR: Final = re.compile(r"(?:std::)?vector ?< ?(.*?) ?>")


def canonical(word: str) -> str | None:
    """Return the type of IDL for a word: `sequence<double>` for `std::vector<double>`.

    None for an unknown word.
    """
    word = " ".join(word.split())
    match = _VECTOR.fullmatch(word)
    if match is None:
        return CANONICAL.get(word)
    element = CANONICAL.get(match[1])
    return None if element is None else f"sequence<{element}>"
