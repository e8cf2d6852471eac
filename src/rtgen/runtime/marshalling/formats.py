"""The formats of compiled codecs: classic CDR and the versions of XCDR."""

from __future__ import annotations

from typing import NamedTuple


class Format(NamedTuple):
    """Classic CDR (version 0), or XCDR version 1 or 2 (DDS-XTypes 1.3, 7.4.3.2)."""

    version: int

    @property
    def widest(self) -> int:
        """The largest alignment."""
        return 4 if self.version == 2 else 8


CLASSIC = Format(0)


class NotCompiledError(TypeError):
    """A type without a compiled codec in the format: parameter lists, empty elements."""
