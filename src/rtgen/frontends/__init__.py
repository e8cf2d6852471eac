"""Front ends: text to model, one package or module for each input language."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rtgen.diagnostics import Diagnostic
from rtgen.model import Model


@dataclass(frozen=True, slots=True)
class Dependency:
    """A path that was looked at: the sha256 of its bytes, or None where there was no file."""

    path: Path
    sha256: str | None


@dataclass(frozen=True, slots=True)
class FrontendResult:
    """What reading a set of definition files gives.

    `sources` maps displayed paths to decoded texts, for the lines that findings point at.
    `dependencies` holds every file read and every path that was tried in vain: as long as none
    of them changes, reading again gives the same.
    """

    model: Model
    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[str, str]
    dependencies: tuple[Dependency, ...]
