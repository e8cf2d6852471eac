"""Copies of files of recordings, which other programs read."""

from __future__ import annotations

import shutil
import tempfile
import weakref
from pathlib import Path


class Copy:
    """A new file in a temporary folder, which is removed with this object."""

    def __init__(self, name: str) -> None:
        folder = tempfile.mkdtemp(prefix="rtgen-bag-")
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        self.path = Path(folder, name)
