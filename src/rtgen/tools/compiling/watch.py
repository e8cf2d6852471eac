"""Implements `rtgen generate --watch`: a run after every change of an input.

File system events and a one-second timer trigger a check; a run starts if an input has changed
since the previous run started reading. So a change during a run is not lost.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.project import FILE_NAME, find
from rtgen.facts.extras import installation
from rtgen.tools.compiling.generation import Request, generate_once
from rtgen.tools.compiling.shown_stages import shown
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import OK

_SECOND_MS = 1000
_SETTLED_MS = 100

State: TypeAlias = dict[Path, tuple[int, int, int] | None]
"""Files with the inode, time and size that identify a version; None for a missing file."""


def watch(console: Console, request: Request) -> int:
    """Run until interrupted. Raises ToolError if watchfiles is not installed."""
    try:
        import watchfiles
    except ImportError as error:
        raise ToolError(
            "--watch needs the package watchfiles, which is not installed",
            hint=installation("watch"),
        ) from error
    files: tuple[Path, ...] = ()
    try:
        while True:
            before, _ = _state(request, files)
            files = _attempt(console, request)
            after, sources = _state(request, files)
            seen = {
                file: before.get(file) if file in before or file in sources else now
                for file, now in after.items()
            }
            console.say("watching; Ctrl-C ends it")
            folders = {file.parent for file in after}
            for _ in watchfiles.watch(
                *(folder for folder in folders if folder.is_dir()),
                recursive=False,
                debounce=_SETTLED_MS,
                rust_timeout=_SECOND_MS,
                yield_on_timeout=True,
            ):
                if _state(request, files)[0] != seen:
                    break
    except KeyboardInterrupt:
        console.say("ended")
    return OK


def _attempt(console: Console, request: Request) -> tuple[Path, ...]:
    """Run once; return the files read or searched for.

    Errors are reported and do not end the watch.
    """
    try:
        with shown(console):
            return tuple(generate_once(console, request)[1])
    except InputError as error:
        console.findings(error.diagnostics)
    except ToolError as error:
        from rtgen.compiler.project_rules import ENVIRONMENT

        console.findings([ENVIRONMENT.at(None, error.message, hint=error.hint)])
    finally:
        console.close()
    return ()


def _state(request: Request, included: Iterable[Path]) -> tuple[State, set[Path]]:
    """Return the state of all inputs, and the sources among them."""
    settings = find(Path.cwd()) or Path.cwd() / FILE_NAME
    try:
        project = request.project()
        paths = (*project.sources, *project.templates.values())
        sources = {path.absolute() for path in paths}
    except (InputError, ToolError):
        sources = {Path(path).absolute() for path in request.definitions.paths}
    files = {settings, *sources, *(path.absolute() for path in included)}
    return {file: _version(file) for file in files}, sources


def _version(file: Path) -> tuple[int, int, int] | None:
    try:
        status = file.stat()
    except OSError:
        return None
    return status.st_ino, status.st_mtime_ns, status.st_size
