"""Doors for files of a project: bus files, `rtgen.toml`, timelines."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from doors import Door
from doors.definitions import known
from doors.mixing import ROOT, files, mixing
from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends import bus
from rtgen.compiler.frontends.profiles import rts_profile
from rtgen.compiler.project import file as project_file
from rtgen.compiler.systems import timeline


def _bus(folder: Path) -> Door:
    for eds in (ROOT / "specs/canopen").glob("*.eds"):
        shutil.copy(eds, folder)
    path = folder / "input.toml"

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        result = bus.load(path, root=folder)
        report(result.diagnostics, {})
        return known(result.diagnostics)

    seeds = files("specs/canopen/*.toml", "tests/runtime/canopen/**/*.toml")
    return Door(enter, mixing(seeds), seeds)


def _rtgen_toml(folder: Path) -> Door:
    path = folder / "rtgen.toml"

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        try:
            settings = project_file.read(path, "rtgen.toml")
        except InputError as error:
            known(error.diagnostics)
            report(error.diagnostics, {})
            return False
        return known(settings.check_paths(folder))

    seeds = files("rtgen.toml", "tests/**/rtgen.toml")
    return Door(enter, mixing(seeds), seeds)


def _timeline(folder: Path) -> Door:
    path = folder / "input.toml"
    read = rts_profile.load(ROOT / "specs/navigation/rh3_goal.xml")
    assert read.system is not None
    system = read.system

    def enter(data: bytes) -> bool:
        path.write_bytes(data)
        try:
            timeline.load(path, system)
        except InputError as error:
            known(error.diagnostics)
            report(error.diagnostics, {})
            return False
        except ToolError:  # it follows a file that does not exist
            return False
        return True

    seeds = files(
        "specs/**/timeline*.toml",
        "specs/**/timelines/*.toml",
        "tests/**/timeline*.toml",
    )
    return Door(enter, mixing(seeds), seeds)


DOORS: dict[str, Callable[[Path], Door]] = {
    "bus": _bus,
    "rtgen-toml": _rtgen_toml,
    "timeline": _timeline,
}
