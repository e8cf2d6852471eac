"""`[run]` of rtgen.toml: what commands about a run take where the command line says nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, InputError, Span
from rtgen.compiler.kit.project_file import find
from rtgen.compiler.project.paths import normal, shown, shown_path
from rtgen.compiler.project.transport_names import ENGINES
from rtgen.compiler.project_rules import PATH_MISSING, RUN_CONFLICT
from rtgen.facts.files import exists, is_file, is_folder

if TYPE_CHECKING:
    from rtgen.compiler.project.file import Settings


class RunTable(msgspec.Struct, frozen=True, kw_only=True):
    """The values of `[run]`; None for those that are missing.

    `system` and `record` are displayed paths; `until` is a condition as text; `spans` has the place
    of each key.
    """

    system: Path | None = None
    clock: str | None = None
    until: str | None = None
    transport: str | None = None
    partition: str | None = None
    record: Path | None = None
    spans: Mapping[str, Span] = msgspec.field(default_factory=dict)

    def is_of(self, system: str | Path) -> bool:
        """Return whether the file or folder is that of `system`."""
        own = self.system
        return own is not None and _file(own).absolute() == _file(system).absolute()


def _file(system: str | Path) -> Path:
    """Return the file of a system, which may be that of a folder."""
    path = normal(Path(system))
    return path / "system.xml" if path.is_dir() else path


def load_run_table() -> RunTable:
    """Return the table of the project of the working folder. Raises InputError."""
    file = find(Path().absolute())
    if file is None:
        return RunTable()
    from rtgen.compiler.project import file as project_file

    settings = project_file.read(file, shown(file))
    findings = [*run_findings(settings, file.parent)]
    if findings:
        raise InputError(findings)
    section = settings.content.get("run", {})
    system, record = (
        shown_path(normal(file.parent / section[key])) if key in section else None
        for key in ("system", "record")
    )
    return RunTable(
        system=system,
        clock=section.get("clock"),
        until=str(section["until"]) if "until" in section else None,
        transport=section.get("transport"),
        partition=section.get("partition"),
        record=record,
        spans={key: settings.span("run", key) for key in section},
    )


def run_findings(settings: Settings, root: Path) -> Iterator[Diagnostic]:
    """Yield the errors in a table whose values are of the right kinds."""
    section = settings.content.get("run", {})
    if "system" in section:
        path = root / section["system"]
        what = ""
        if not exists(path):
            what = "no file or folder"
        elif is_folder(path) and not is_file(path / "system.xml"):
            what = "no system.xml in the folder"
        if what:
            message = f"{what} {section['system']!r}"
            yield PATH_MISSING.at(settings.span("run", "system"), message)
    if "until" in section:
        # Not imported without need: it reads profiles.
        from rtgen.compiler.systems import conditions

        try:
            conditions.condition(
                str(section["until"]), None, settings.span("run", "until")
            )
        except InputError as error:
            yield from error.diagnostics
    transport = section.get("transport", "direct")
    if transport in ENGINES and section.get("clock", "sim") != "real":
        message = (
            f"transport {transport!r} joins processes, which share no simulated time"
        )
        span = settings.span("run", "transport")
        yield RUN_CONFLICT.at(span, message, hint='add clock = "real"')
    if "partition" in section and transport not in ENGINES:
        message = f"transport {transport!r} has no partitions"
        span = settings.span("run", "partition")
        yield RUN_CONFLICT.at(span, message, hint='transport = "dds" or "zenoh"')
