"""Files that docs/deployment.md tells users to copy are valid for their programs."""

from __future__ import annotations

import configparser
import json
import re
import shlex
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from string import Template
from typing import Any

import pytest
import yaml
from click import Command, Context

from rtgen.cli import application
from rtgen.compiler.frontends.profiles import rts_profile

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs/deployment.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)


def blocks(kind: str) -> list[str]:
    return [text for found, text in BLOCK.findall(PAGE) if found == kind]


UNIT, *ENVIRONMENTS = blocks("ini")
[COMPOSITION] = blocks("yaml")
[IMAGE] = blocks("dockerfile")


def run_options(words: list[str]) -> dict[str, Any]:
    """Return the options of `rtgen run` in a command line. Raises UsageError."""
    assert words[0] == "run"
    command = application.get_command(Context(application), "run")
    assert isinstance(command, Command)
    return command.make_context("run", words[1:]).params


def by_systemd() -> list[dict[str, Any]]:
    """Return the options of the processes that the systemd unit starts."""
    unit = configparser.ConfigParser(interpolation=None, strict=False)
    unit.optionxform = str  # type: ignore[assignment,method-assign]
    unit.read_string(UNIT)
    line = unit["Service"]["ExecStart"]
    return [
        run_options(
            shlex.split(
                Template(line).substitute(
                    dict(each.split("=", 1) for each in text.splitlines())
                )
            )[1:]
        )
        for text in ENVIRONMENTS
    ]


def in_containers() -> list[dict[str, Any]]:
    """Return the options of the processes in the containers."""
    found = re.search(r"^ENTRYPOINT (.*)$", IMAGE, re.MULTILINE)
    assert found is not None
    entry = json.loads(found[1])
    services = yaml.safe_load(COMPOSITION)["services"]
    return [
        run_options([*entry[1:], *service["command"]])
        for service in services.values()
        if "build" in service
    ]


@pytest.mark.parametrize("way", [by_systemd, in_containers])
def test_the_processes_run_each_component_once(
    way: Callable[[], list[dict[str, Any]]],
) -> None:
    processes = way()
    [file] = {str(each["system"]) for each in processes}
    system = rts_profile.load(ROOT / file).system
    assert system is not None
    run = [name for each in processes for name in str(each["only"]).split(",")]
    assert sorted(run) == sorted(c.instance for c in system.components)


def test_the_unit_is_one_of_systemd(tmp_path: Path) -> None:
    program = shutil.which("systemd-analyze")
    if program is None:
        pytest.skip("systemd-analyze is missing")
    rtgen = shutil.which("true")
    unit = tmp_path / "rtgen@.service"
    unit.write_text(UNIT.replace("/opt/robot/.venv/bin/rtgen", rtgen or "/bin/true"))
    found = subprocess.run(
        [program, "verify", "--man=no", f"{tmp_path}/rtgen@drive.service"],
        capture_output=True,
        text=True,
        check=False,
    )
    own = [line for line in found.stderr.splitlines() if "rtgen@" in line]
    assert own == []
