"""Names in the Python modules that omniidl generates (omniORBpy 4.3)."""

from __future__ import annotations

import keyword
from typing import Final

STAND_IN: Final = "opaque"
"""The only member, an octet, of the placeholder of an unknown struct."""


def mangled(name: str) -> str:
    """Return an identifier of IDL in Python: keywords get a leading underscore."""
    return f"_{name}" if keyword.iskeyword(name) else name


def opaque_id(scoped: str) -> str:
    """Return the repository id of the placeholder of an unknown struct, such as `RTC::Time`."""
    return f"IDL:rtgen.opaque/{scoped.replace('::', '/')}:1.0"
