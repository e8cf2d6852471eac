"""Arrangements of the wiring that pages have computed, stored for the next page of a graph."""

from __future__ import annotations

import contextlib
import os
import re
import threading
from pathlib import Path
from typing import Final

import msgspec

from rtgen.compiler.kit import stored_files
from rtgen.compiler.kit.own_files import read_own, user_folder

MAX_OCTETS: Final = 1 << 20
"""Maximum size of an arrangement."""
_KEY: Final = re.compile(r"[0-9a-f]{64}")


class _Arrangement(msgspec.Struct, forbid_unknown_fields=True):
    """What a page reads: names and left upper corners of boxes, names and corners of wires [px]."""

    width: float
    height: float
    boxes: list[tuple[str, float, float]]
    wires: list[tuple[str, list[tuple[float, float]]]]


_DECODER: Final = msgspec.json.Decoder(_Arrangement)


class Arrangements:
    """Arrangements by the hashes of their graphs, in a folder; from any thread."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock = threading.Lock()

    def get(self, key: str) -> bytes | None:
        """Return the arrangement of a graph as JSON; None if there is none of the form."""
        file = self._folder / f"{key}.json"
        data = read_own(str(file), MAX_OCTETS + 1)
        if data is None or not is_arrangement(data):
            return None
        with contextlib.suppress(OSError):
            os.utime(file)  # those that are used stay
        return data

    def put(self, key: str, data: bytes) -> None:
        """Store the arrangement of a graph, if the folder can be written."""
        with self._lock:
            stored_files.write(self._folder, f"{key}.json", data)


def of_user() -> Arrangements:
    """Return the arrangements in the user's folder of caches."""
    return Arrangements(Path(user_folder()) / "ui" / "arrangements")


def is_key(text: str) -> bool:
    """Return whether a text is the hash of a graph."""
    return _KEY.fullmatch(text) is not None


def is_arrangement(data: bytes) -> bool:
    """Return whether a JSON text has the form of an arrangement, and is not too large."""
    if len(data) > MAX_OCTETS:
        return False
    try:
        _DECODER.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return False
    return True
