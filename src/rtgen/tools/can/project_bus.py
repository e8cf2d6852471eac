"""The bus of a project, for commands that are told no bus file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rtgen.compiler.project import (
    is_bus_file,
    is_other_kind,
    load,
    load_run_table,
    shown,
)
from rtgen.tools.kit.console import Console
from rtgen.tools.kit.exits import Refusal


def project_buses(console: Console) -> list[Path]:
    """Return the bus files of the project of the working folder.

    Of several, those whose nodes the system of `[run]` has proxies of, if there are some. Raises
    InputError, ReportedError.
    """
    files = [path for path in load().sources if is_bus_file(path)]
    system = load_run_table().system
    if len(files) < 2 or system is None:
        return files
    from rtgen.compiler.frontends import bus as front_end
    from rtgen.tools.can.writing_rates import has_proxies
    from rtgen.tools.running.plan import read_system

    profile = read_system(system, console)
    read = [(file, front_end.load(file, root=Path.cwd()).bus) for file in files]
    used = [f for f, bus in read if bus is not None and has_proxies(bus, profile)]
    return used or files


def require_bus_file(file: Path) -> None:
    """Raise Refusal for a file whose name is that of another kind."""
    if is_other_kind(file, (".toml",)):
        raise Refusal(f"{file} is not a bus file")


def listed(files: Sequence[Path]) -> str:
    """Return the names of files for a message."""
    return ", ".join(map(shown, files))
