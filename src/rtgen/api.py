"""The Python API: compile definitions to a model, and a model to files, in scripts and tests.

docs/api.md shows their use.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence

from msgspec.structs import replace

from rtgen.compiler import compilation
from rtgen.compiler.backends import Backend, Emission, Options, stage
from rtgen.compiler.diagnostics import InputError, has_errors, in_order
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit.library import VirtualFile
from rtgen.compiler.frontends.stage import read_idl
from rtgen.compiler.model import Model
from rtgen.compiler.printed_idl import interfaces, printed_idl
from rtgen.compiler.project import load, with_arguments
from rtgen.facts.version import __version__

__all__ = ["compile", "emit", "read"]

Paths = str | os.PathLike[str]

TEXT = "text.idl"
"""The file name in declarations and diagnostics of a source given as text."""


def read(
    source: Paths | Iterable[Paths],
    *,
    include: Sequence[Paths] = (),
    define: Mapping[str, str] | None = None,
    lowered: bool = False,
) -> FrontendResult:
    """Return the model of definitions, with its diagnostics.

    `source` is IDL (`str`), the path of a file or folder (`pathlib.Path`), or a list of paths
    (`str` or `Path`). The settings of the nearest `rtgen.toml` of the working folder apply, if
    there is one, but not its sources. `include` are further include folders, `define` macros by
    name; `lowered` adds what lowerings make: the types and the components of devices, the packages
    of TECS boards. Back ends need it for these.

    Raises InputError for a path that is not a definition and for an invalid `rtgen.toml`; errors in
    definitions are among the diagnostics.
    """
    paths: list[str] = []
    if not isinstance(source, str):
        several = [source] if isinstance(source, os.PathLike) else source
        paths = [os.fspath(path) for path in several]
    project = with_arguments(
        load(),
        paths=paths,
        include=[os.fspath(folder) for folder in include],
        define=tuple((define or {}).items()),
    )
    project = (
        project if paths else replace(project, sources=(), systems=(), adapters=())
    )
    also = []
    if isinstance(source, str):
        text = VirtualFile(TEXT, source, given=True)
        printed = printed_idl(Model())
        definitions = interfaces(project.reading)
        also.append(
            read_idl(
                (), project.reading, text=text, printed=printed, interfaces=definitions
            )
        )
    return compilation.read(project, lowered=lowered, also=also)


def compile(  # noqa: A001 - the name that users look for, as in re.compile
    source: Paths | Iterable[Paths],
    *,
    include: Sequence[Paths] = (),
    define: Mapping[str, str] | None = None,
    lowered: bool = False,
) -> Model:
    """Return the model of definitions; the arguments are those of `read`.

    Raises InputError with the `diagnostics` if there are errors.
    """
    result = read(source, include=include, define=define, lowered=lowered)
    if has_errors(result.diagnostics):
        raise InputError(result.diagnostics)
    return result.model


def emit(
    model: Model, *backends: str | Backend, options: Options | None = None
) -> Emission:
    """Return the files that back ends generate from a model, and their diagnostics; writes nothing.

    `backends` are back ends or names of installed ones; the default is all of them. `options`
    default to those of a project without `rtgen.toml`. Raises ValueError for an unknown name.
    """
    installed = {backend.name: backend for backend in stage.backends()}
    unknown = [b for b in backends if isinstance(b, str) and b not in installed]
    if unknown:
        names = ", ".join(installed)
        raise ValueError(f"no back end is called {unknown[0]!r}; there are: {names}")
    chosen = [installed[b] if isinstance(b, str) else b for b in backends]
    settings = options or Options("robots", "", __version__)
    emission = stage.emitted(model, settings, chosen or installed.values())
    return replace(
        emission,
        artifacts=tuple(emission.artifacts),
        diagnostics=tuple(in_order(emission.diagnostics)),
    )
