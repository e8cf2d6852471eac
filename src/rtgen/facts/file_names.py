"""Names that files cannot have."""

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
