"""Numbers of references, by which a value is given away or reused that nothing else refers to."""

from __future__ import annotations

import sys
from typing import Final


def _are_exact() -> bool:
    has_lock = getattr(sys, "_is_gil_enabled", lambda: True)
    return sys.implementation.name == "cpython" and has_lock()


EXACT: Final = _are_exact()
"""Whether this interpreter has exact numbers of references."""

COUNTS_VARIABLES: Final = EXACT and sys.version_info < (3, 14)
"""Whether each variable and each argument counts. CPython 3.14 passes some arguments uncounted."""
