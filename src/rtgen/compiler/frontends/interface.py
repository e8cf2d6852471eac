"""Interface of front ends, which read definitions into a model: one package per input language."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, in_order

if TYPE_CHECKING:  # the rules of front ends are read without it
    from rtgen.compiler.model import Model


class Dependency(msgspec.Struct, frozen=True):
    """A path that was read or searched for: the sha256 of its content, or None if it is missing."""

    path: Path
    sha256: str | None


class FrontendResult(msgspec.Struct, frozen=True):
    """Result of reading a set of definition files.

    `sources` maps displayed paths to decoded texts, for excerpts in diagnostics. `dependencies`
    holds every file that was read and every path that was searched for: while none of them
    changes, reading again gives the same result. `idl` are IDL files that the definitions name.
    """

    model: Model
    diagnostics: tuple[Diagnostic, ...]
    sources: Mapping[str, str]
    dependencies: tuple[Dependency, ...]
    idl: tuple[Path, ...] = ()

    @property
    def hashes(self) -> dict[str, str | None]:
        """The dependencies: sha256 by absolute path, None for what is missing."""
        return {str(d.path.absolute()): d.sha256 for d in self.dependencies}


class Frontend(Protocol):
    """Interface of a front end, as provided by an entry point `rtgen.frontends`."""

    @property
    def suffixes(self) -> Sequence[str]:
        """The suffixes of its files, in lower case, with the dot."""
        ...

    def load(
        self,
        paths: Sequence[Path],
        *,
        root: Path,
        include: Sequence[Path],
        options: Mapping[str, Any],
    ) -> FrontendResult:
        """Return the model of the files, which are read together.

        `root` is the project's folder, `include` its include folders, `options` the table
        `[plugin.NAME]` of rtgen.toml. Errors in the input are among the diagnostics; nothing is
        raised.
        """
        ...


def key_of(path: Path, root: Path) -> str:
    """Return the path for generated text: relative to the project, else the file name."""
    try:
        return path.resolve().relative_to(root.resolve()).as_posix()
    except ValueError:
        return path.name


def together(results: Sequence[FrontendResult]) -> FrontendResult:
    """Merge the results of several front ends."""
    from rtgen.compiler.model import Model

    models = [result.model for result in results]
    return FrontendResult(
        model=Model(
            files=tuple(f for m in models for f in m.files),
            declarations=tuple(d for m in models for d in m.declarations),
            systems=tuple(s for m in models for s in m.systems),
            tecs=tuple(u for m in models for u in m.tecs),
            devices=tuple(d for m in models for d in m.devices),
            buses=tuple(b for m in models for b in m.buses),
            profiles=tuple(p for m in models for p in m.profiles),
            adapters=tuple(a for m in models for a in m.adapters),
        ),
        diagnostics=tuple(in_order(d for r in results for d in r.diagnostics)),
        sources={name: text for r in results for name, text in r.sources.items()},
        dependencies=tuple(d for r in results for d in r.dependencies),
        idl=tuple(dict.fromkeys(path for r in results for path in r.idl)),
    )
