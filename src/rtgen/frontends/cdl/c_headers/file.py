"""A C header as read from the disk: its name, digest and decoded text."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path

from rtgen.frontends.cdl.text import encodings


class HeaderFile:
    """A C header, or a file that it includes."""

    def __init__(self, name: str, key: str, path: Path, data: bytes | None) -> None:
        self.name = name
        self.key = key
        self.path = path
        self.too_large = data is None
        self.sha256 = sha256(data or b"").hexdigest()
        self.text = encodings.decode(data or b"", "auto")[0].removeprefix("\ufeff")
