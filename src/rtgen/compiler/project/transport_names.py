"""The names of rtgen's own transports."""

from __future__ import annotations

from typing import Final

ENGINES: Final = ("dds", "zenoh")
"""Transports that join the processes of a partition."""
TRANSPORTS: Final = ("direct", "corba", *ENGINES)
"""Transports that are no plug-ins."""
