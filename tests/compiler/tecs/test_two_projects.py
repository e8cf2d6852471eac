"""Two projects with a CDL file of one name each, installed into one environment, used at once."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from boards import joined

from rtgen.cli import run

USE = """\
from left.tecs.board.lamp_marshaller import LampProxy as LeftProxy
from left.tecs.board.lamp_server import LampTarget as LeftTarget
from left.tecs.board.lamp_server import LampUnmarshaller as LeftUnmarshaller
from left_nodes.lamp_client import LampClient as LeftClient
from right.tecs.board.lamp_marshaller import LampProxy as RightProxy
from right.tecs.board.lamp_server import LampTarget as RightTarget
from right.tecs.board.lamp_server import LampUnmarshaller as RightUnmarshaller
from right_nodes.lamp_client import LampClient as RightClient

from rtgen.runtime.opaque_rpc import TcpChannel, TcpServer


class Left(LeftTarget):
    def dim(self, percent: int) -> int:
        return percent + 1


class Right(RightTarget):
    def dim(self, text: str) -> int:
        return len(text)


with (
    TcpServer(LeftUnmarshaller(Left())) as left,
    TcpServer(RightUnmarshaller(Right())) as right,
):
    one, other = TcpChannel(*left.address), TcpChannel(*right.address)
    print(LeftProxy(one).dim(40), RightProxy(other).dim("four"))
    one.close()
    other.close()
print(*(client.__base__.__module__ for client in (LeftClient, RightClient)))
"""


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with the packages of both projects, as installing puts them there."""
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    site = tmp_path / "site"
    site.mkdir()
    for name, parameter in (
        ("left", "[in] uint8_t percent"),
        ("right", "[in,string] const char_t *text"),
    ):
        folder = tmp_path / name
        (folder / "cdl").mkdir(parents=True)
        text = f"signature sLamp {{ ER dim( {parameter} ); }};\n"
        (folder / "cdl" / "board.cdl").write_text(joined(text, "sLamp"))
        (folder / "rtgen.toml").write_text(
            f'[sources]\npaths = ["cdl"]\n'
            f'[output]\npackage = "{name}"\nskeletons = "src/{name}_nodes"\n'
        )
        monkeypatch.chdir(folder)
        assert run(["generate"]) == 0
        for package in (f"generated/{name}", f"src/{name}_nodes"):
            shutil.copytree(folder / package, site / Path(package).name)
    return site


def test_both_are_used_at_once(environment: Path) -> None:
    assert sorted(path.name for path in environment.iterdir()) == [
        "left",
        "left_nodes",
        "right",
        "right_nodes",
    ]
    done = subprocess.run(
        [sys.executable, "-c", USE], cwd=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split("\n")[:2] == [
        "41 4",
        "left.tecs.board.lamp_marshaller right.tecs.board.lamp_marshaller",
    ]
