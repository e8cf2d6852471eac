"""Back end for data types and interfaces: Python classes with CDR codecs."""

from __future__ import annotations

from rtgen.compiler.backends.types.backend import BACKEND, TypesBackend
from rtgen.compiler.backends.types.rules import RULES

__all__ = ["BACKEND", "RULES", "TypesBackend"]
