"""Modules loaded by importing a package: the runtime is light, the commands are lazy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

COMPILER_LIBRARIES = (
    "lark",
    "jinja2",
    "black",
    "click",
    "rich",
    "lxml",
    "matplotlib",
    "pcpp",
    "pycparser",
)
DEVICE_LIBRARIES = ("serial", "canopen", "can")


def loaded_by(code: str) -> set[str]:
    """Return the top-level modules that are loaded after running the code in a new interpreter."""
    probe = (
        f"{code}\nimport sys\nprint(*sorted({{m.split('.')[0] for m in sys.modules}}))"
    )
    command = [sys.executable, "-c", probe]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return {*done.stdout.splitlines()[-1].split()}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "code",
    [
        "import rtgen.runtime",
        "import refrobots.iis, refrobots.rtc",
        "import refrobots.components.path_follower",
        "import refnav.path_follower",
        "import rtgen.runtime.opaque_rpc, rtgen.runtime.canopen",
        "import refrobots.tecs.board.motor_board_marshaller",
        "import refrobots.tecs.board.motor_board_server",
        "import refnav.ref_hard_rh3_tecs, refnav.simulated_motor_board",
    ],
)
def test_running_components_needs_no_compiler(code: str) -> None:
    assert not loaded_by(code) & {*COMPILER_LIBRARIES, *DEVICE_LIBRARIES}


def test_the_command_line_loads_no_heavy_library_by_itself() -> None:
    heavy = {*COMPILER_LIBRARIES, *DEVICE_LIBRARIES} - {"click"}
    assert not loaded_by("import rtgen.cli, rtgen.cli.rpc, rtgen.cli.can") & heavy


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "command",
    [
        ("generate", "--no-cache", "-o", "{output}"),
        ("run", "specs/navigation/rh3_goal.xml", "--until", "0.001"),
    ],
)
def test_commands_load_neither_mail_nor_the_web(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`importlib.metadata` reads mail, `xml.sax.saxutils` opens URLs: a tenth of a start."""
    monkeypatch.chdir(Path(__file__).parents[2])
    arguments = [each.format(output=tmp_path / "o") for each in command]
    code = f"import rtgen.cli\nassert rtgen.cli.run({arguments!r}) == 0"
    assert not loaded_by(code) & {"email", "http", "lark", "lxml", "matplotlib"}


def test_recordings_load_mcap_when_a_file_is_opened() -> None:
    code = "import rtgen.cli.run, rtgen.cli.replay, rtgen.cli.log.cat_command"
    assert not loaded_by(code) & {"mcap", "lz4", "zstandard"}
