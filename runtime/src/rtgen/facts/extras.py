"""How an extra is installed, for hints: rtgen is on no package index, where anyone could take its
names.
"""

from __future__ import annotations


def installation(extra: str) -> str:
    """Return the command that installs an extra, and where."""
    return f"pip install ./runtime '.[{extra}]' in a clone of rtgen"
