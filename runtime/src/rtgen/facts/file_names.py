"""Names and paths that files cannot have."""

from __future__ import annotations

DEVICES = frozenset(
    {
        *("aux", "con", "conin$", "conout$", "nul", "prn"),
        *(f"{port}{number}" for port in ("com", "lpt") for number in range(10)),
    }
)
"""Names of devices of Windows, in lower case: no file has one, whatever its suffix.

Microsoft, "Naming Files, Paths, and Namespaces".
"""


def is_device(name: str) -> bool:
    """Return whether a file of this name would be a device of Windows."""
    stem = name.partition(".")[0].rstrip(" ")
    return stem.casefold() in DEVICES


MAX_NAME, MAX_PATH = 255, 4000
"""Octets of a name and of a path that file systems allow; some are left for what is added."""


def problem(path: str) -> str | None:
    """Return what keeps a path from being that of a file, as words; None if nothing does."""
    if "\0" in path:
        return "has a NUL"
    try:
        octets = path.encode()
    except UnicodeEncodeError:
        return "is not UTF-8"
    if any(len(name) > MAX_NAME for name in octets.split(b"/")):
        return f"has a name of more than {MAX_NAME} octets"
    return f"has more than {MAX_PATH} octets" if len(octets) > MAX_PATH else None
