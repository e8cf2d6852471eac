"""The two wheels of this repository: content, requirements, and use in separate environments."""

from __future__ import annotations

import configparser
import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from environments import UV, build_wheel

from rtgen.compiler.backends.kit.rendering import template_names
from rtgen.compiler.diagnostics.explain import rules
from rtgen.compiler.kit.resources import RH3_FILES, RH3_FOLDER
from rtgen.facts.version import __version__

ROOT = Path(__file__).parents[3]
BUILT_FROM = (
    *("src", "runtime", "reference", "grammars"),
    *("specs/idl", "specs/navigation"),
)
FILES = ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE")
NAME = re.compile(r"[\w-]+")

# Code of IDL (a base and its odometry), of TECS (a call of a board) and of CANopen (a drive).
DRIVE = """
from importlib import import_module
from pkgutil import walk_packages
import refrobots
for module in walk_packages(refrobots.__path__, "refrobots."):
    import_module(module.name)
from refnav.odometry import Odometry
from refnav.ref_hard_rh3 import RefHardRh3
from refrobots import rtc
from rtgen.runtime import SECOND, LifeCycleState, SimulatedClock, System
with System(SimulatedClock()) as system:
    system.add(RefHardRh3("Base0"), 1000.0)
    system.add(Odometry("Odometry0"), 100.0)
    system.connect(("Base0", "OutWheelAngle"), ("Odometry0", "CurrentWheelAngle"))
    system.activate("Base0")
    system.activate("Odometry0")
    system.run(until_ns=SECOND)
    assert system.state("Odometry0") is LifeCycleState.ACTIVE_STATE
sample = rtc.TimedDoubleSeq(rtc.Time(1, 2), [3.0])
assert rtc.TimedDoubleSeq.from_cdr(sample.to_cdr()) == sample

import threading
from refnav.base_control import start_of
from refnav.motor_board import MotorBoard
from refrobots.components.simulated_motor_board import SimulatedMotorBoardConfiguration
from refrobots.tecs.board.motor_board_codec import MotorBoardCodec
from refrobots.tecs.board.motor_board_marshaller import MotorBoardProxy
from refrobots.tecs.board.motor_board_server import MotorBoardUnmarshaller
from rtgen.runtime.opaque_rpc import TcpChannel, TcpServer
config = SimulatedMotorBoardConfiguration()
board = MotorBoard(config, start_of(config), lambda: 0, print)
with TcpServer(MotorBoardUnmarshaller(board, MotorBoardCodec())) as server:
    threading.Thread(target=server.serve_forever, daemon=True).start()
    # The machine may be busy with other tests.
    channel = TcpChannel(*server.address, timeout=120.0)
    assert MotorBoardProxy(channel).identify() == (0, "RH3 motor board, simulated")
    channel.close()

from refnav.epos_drive_device import EposDriveDevice
from refrobots.components.epos_drive_proxy import EposDriveProxy
device, proxy = EposDriveDevice("Device0"), EposDriveProxy("Drive0")
proxy.configuration_sets.set("master", "1")
with System(SimulatedClock()) as system:
    for component in (device, proxy):
        for name, value in (("node_id", "1"), ("network", ""), ("bitrate", "1000000")):
            component.configuration_sets.set(name, value)
        system.add(component, 100.0)
        system.run(until_ns=system.time + SECOND)
    system.activate("Drive0")
    system.run(until_ns=system.time + SECOND)
    assert system.state("Drive0") is LifeCycleState.ACTIVE_STATE, proxy.reason
try:
    import rtgen.compiler.compilation
except ModuleNotFoundError:
    print("runs without a compiler")
"""

pytestmark = [pytest.mark.slow, pytest.mark.nightly]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the sources of both wheels, copied: a build writes tables beside the grammars."""
    copy = tmp_path_factory.mktemp("source")
    for name in BUILT_FROM:
        shutil.copytree(
            ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in FILES:
        shutil.copy(ROOT / name, copy)
    return copy


@pytest.fixture(scope="module")
def whole(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_wheel(source, tmp_path_factory.mktemp("whole"))


@pytest.fixture(scope="module")
def runtime(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_wheel(source / "runtime", tmp_path_factory.mktemp("runtime"))


def test_a_second_build_gives_the_same_octets(
    source: Path, whole: Path, runtime: Path, tmp_path: Path
) -> None:
    """In another folder, with other file times and hashes."""
    again = shutil.copytree(
        source, tmp_path / "elsewhere", copy_function=shutil.copyfile
    )
    for first, project in ((whole, again), (runtime, again / "runtime")):
        second = build_wheel(project, tmp_path / first.name, PYTHONHASHSEED="4711")
        assert second.read_bytes() == first.read_bytes()


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_wheel_is_rtgen_alone(whole: Path) -> None:
    found = contents(whole)
    info = whole.name.removesuffix("-py3-none-any.whl") + ".dist-info"
    assert {name.partition("/")[0] for name in found} == {"rtgen", info}
    entries = configparser.ConfigParser()
    entries.read_string(found[f"{info}/entry_points.txt"].decode())
    assert {name: dict(entries[name]) for name in entries.sections()} == {
        "console_scripts": {"rtgen": "rtgen.__main__:main"}
    }
    for name in ("compiler/compilation.py", "api.py", "grammars/idl.lark"):
        assert f"rtgen/{name}" in found
    code = found["rtgen/compiler/backends/kit/template_code.py"].decode()
    assert code.count("\ndef template_") == len(template_names())
    pages = {Path(name).stem for name in found if name.endswith(".md")}
    assert pages >= set(rules())


def test_the_wheel_has_the_reference_pipeline_as_data(whole: Path) -> None:
    found = contents(whole)
    data = {name: found[f"rtgen/{RH3_FOLDER}/{name}"] for name in RH3_FILES}
    assert data == {n: (ROOT / path).read_bytes() for n, path in RH3_FILES.items()}
    folder = {name for name in found if name.startswith(f"rtgen/{RH3_FOLDER}/")}
    assert len(folder) == len(data)
    with zipfile.ZipFile(whole) as archive:
        packed = sum(archive.getinfo(name).compress_size for name in folder)
    assert packed < 64 * 1024


def test_the_wheels_share_no_file(whole: Path, runtime: Path) -> None:
    """Removing or replacing one leaves the files of the other."""
    part, rest = contents(runtime).keys(), contents(whole).keys()
    assert not part & rest
    packages = {name.split("/")[1] for name in part if name.startswith("rtgen/")}
    assert packages == {"facts", "runtime", "small_runtime"}
    assert not packages & {name.split("/")[1] for name in rest}
    assert "rtgen/__init__.py" not in part | rest


@pytest.mark.parametrize("first", ["rtgen", "rtgen-runtime"])
def test_each_is_removed_without_the_other(
    first: str, whole: Path, runtime: Path, tmp_path: Path
) -> None:
    python, pip = environment(tmp_path)
    subprocess.run([*pip, "install", "--quiet", str(runtime), str(whole)], check=True)
    check = subprocess.run([*pip, "check"], capture_output=True, text=True)
    assert (check.returncode, check.stdout) == (0, "No broken requirements found.\n")
    subprocess.run([*pip, "uninstall", "--quiet", "--yes", first], check=True)
    check = subprocess.run([*pip, "check"], capture_output=True, text=True)
    if first == "rtgen":
        assert check.returncode == 0
        subprocess.run([python, "-c", "import rtgen.runtime"], check=True)
        return
    assert "rtgen-runtime, which is not installed" in check.stdout
    done = subprocess.run(
        [python, "-m", "rtgen", "--version"], capture_output=True, text=True
    )
    assert done.returncode == 1
    assert "hint: pip install ./runtime in a clone" in done.stderr
    subprocess.run([*pip, "install", "--quiet", str(runtime)], check=True)
    subprocess.run([python, "-m", "rtgen", "--version"], check=True)


def environment(folder: Path) -> tuple[str, list[str]]:
    """Return the interpreter of a new environment without packages, and pip for it."""
    bare = folder / "bare"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", bare], check=True)
    python = str(bare / "bin" / "python")
    pip = [sys.executable, "-m", "pip", "--python", python]
    return python, [*pip, "--disable-pip-version-check"]


def test_generated_code_runs_with_the_runtime_alone(
    runtime: Path, tmp_path: Path
) -> None:
    python, pip = environment(tmp_path)
    subprocess.run([*pip, "install", "--quiet", str(runtime)], check=True)
    listed = subprocess.run(
        [*pip, "list", "--format", "json"], check=True, capture_output=True, text=True
    )
    settings = tomllib.loads((ROOT / "runtime" / "pyproject.toml").read_text("utf-8"))
    needs = {NAME.match(need) for need in settings["project"]["dependencies"]}
    names = {found.group() for found in needs if found}
    assert {each["name"] for each in json.loads(listed.stdout)} == {
        "rtgen-runtime",
        *names,
    }
    (tmp_path / "behaviours").mkdir()
    (tmp_path / "behaviours" / "refnav").symlink_to(ROOT / "reference" / "refnav")
    path = os.pathsep.join([str(ROOT / "generated"), str(tmp_path / "behaviours")])
    done = subprocess.run(
        [python, "-W", "error", "-c", DRIVE],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    printed = done.stdout, done.stderr
    assert printed == ("runs without a compiler\n", ""), printed


def test_the_source_of_the_codecs_in_c_is_whole(runtime: Path, tmp_path: Path) -> None:
    if not UV.exists() or shutil.which("cc") is None:
        pytest.skip("uv, or a compiler, is missing")
    copy = shutil.copytree(
        ROOT / "speed", tmp_path / "speed", ignore=shutil.ignore_patterns("build")
    )
    # uv builds the source distribution, and the wheel from it.
    built = [UV, "build", "--quiet", "--out-dir", tmp_path / "dist", copy]
    subprocess.run(built, check=True)
    [source] = (tmp_path / "dist").glob("*.tar.gz")
    [wheel] = (tmp_path / "dist").glob("*.whl")
    assert source.name == f"rtgen_speed-{__version__}.tar.gz"
    python, pip = environment(tmp_path)
    subprocess.run([*pip, "install", "--quiet", str(runtime), str(wheel)], check=True)
    tried = subprocess.run(
        [python, ROOT / "speed" / "try.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert re.fullmatch(r"\d+ types in C\n", tried.stdout), tried.stderr
