"""A C header as read from the disk: its name, digest and decoded text."""

from __future__ import annotations

from pathlib import Path

from rtgen.compiler.frontends.kit import characters
from rtgen.compiler.frontends.kit.characters import Joined
from rtgen.facts.encodings import digest

_BREAKS = str.maketrans(dict.fromkeys("\v\f\x1c\x1d\x1e\x85\u2028\u2029", " "))
"""Characters that end a line to `str.splitlines`, as pcpp uses it, and not in C."""
_READERS = "gcc and tecsgen"
"""Programs that read the octets of C headers; tecsgen preprocesses them with gcc."""


class HeaderFile:
    """A C header, or a file that it includes.

    `text` has its lines joined at backslashes, and as many lines as the file.
    """

    def __init__(
        self,
        name: str,
        key: str,
        path: Path,
        data: bytes | None,
        encoding: str = "auto",
    ) -> None:
        self.name = name
        self.key = key
        self.path = path
        self.too_large = data is None
        self.sha256 = digest(data or b"")
        self._characters = characters.read(data or b"", name, encoding)
        self._characters.check_line_ends()
        self.source = self._characters.text
        self.problems = self._characters.problems
        joined = Joined(self.source, blanks=True)
        self._characters.check(joined, _READERS, literals=False)
        self.text = joined.with_all_lines().translate(_BREAKS)
