"""Interfaces of an installation of ROS 2, included from IDL, which each package has as well.

Their hashes are compared with those that the installation has (REP 2016).
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable
from pathlib import Path

import pytest
from ros2_peers import DISTRIBUTIONS, installation
from seeds import seed

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.layouts.ros_types import type_hash
from rtgen.compiler.model import Const, Model, Struct
from rtgen.facts.ros import INTERFACE_KINDS

pytestmark = [pytest.mark.peer, pytest.mark.nightly]

BY_HAND = ("KeyedLong", "KeyedString", "NonKeyedWithNestedKey", "ComplexNestedKey")
"""Messages of Kilted that are IDL written by hand: as sources, they are no interface files."""
KINDS = {*INTERFACE_KINDS.values()}
NO_MESSAGES = ("_Event", "_SendGoal", "_GetResult")
"""Ends of the names of derived services and of their events."""


@pytest.fixture(scope="module", params=DISTRIBUTIONS)
def share(request: pytest.FixtureRequest) -> Path:
    return installation(request.param).share


@pytest.fixture(scope="module")
def idl_alone(share: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the packages without the files that their IDL was generated from."""
    folder = tmp_path_factory.mktemp("share")
    for path in share.glob("*/*/*.idl"):
        copy = folder / path.relative_to(share)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    return folder


def names(share: Path) -> list[str]:
    """Return the names of all interfaces: `std_msgs/msg/String`."""
    files = (p for p in share.glob("*/*/*.idl") if p.parent.name in KINDS)
    return sorted(p.relative_to(share).with_suffix("").as_posix() for p in files)


def hashes(share: Path, name: str) -> dict[str, str]:
    """Return the hashes of an interface's messages by their names."""
    described = json.loads((share / f"{name}.json").read_text("utf-8"))
    of_types = {e["type_name"]: e["hash_string"] for e in described["type_hashes"]}
    package, kind, last = name.split("/")
    own = (n for n in of_types if n.startswith(f"{package}/{kind}/{last}"))
    return {
        each: of_types[each]
        for each in own
        if not each.endswith(NO_MESSAGES) and (kind == "msg" or each != name)
    }


def model_of(text: str, share: Path) -> Model:
    result = api.read(text, include=[share])
    assert not [d for d in result.diagnostics if d.severity is not Severity.NOTE]
    return result.model


def includes(found: Iterable[str]) -> str:
    return "".join(f'#include "{name}.idl"\n' for name in found)


@pytest.mark.parametrize("form", ["all files", "IDL alone"])
def test_the_hash_of_each_message(form: str, share: Path, idl_alone: Path) -> None:
    every = names(share)
    assert len(every) >= 199
    model = model_of(includes(every), share if form == "all files" else idl_alone)
    compared = 0
    for name in every:
        for message, expected in hashes(share, name).items():
            struct = model.find(tuple(message.split("/")))
            assert isinstance(struct, Struct), message
            assert type_hash(model, struct) == expected, message
            compared += 1
    assert compared > 230


@pytest.mark.parametrize("form", ["all files", "IDL alone"])
def test_each_is_included_alone(form: str, share: Path, idl_alone: Path) -> None:
    """A fifth of them by the seed of the run: the test above includes all together."""
    folder = share if form == "all files" else idl_alone
    for name in names(share)[seed() % 5 :: 5]:
        package, kind, last = name.split("/")
        ends = {"msg": "", "srv": "_Request", "action": "_Goal"}
        model = model_of(includes([name]), folder)
        assert model.find((package, kind, last + ends[kind])), name


def test_defaults_are_those_of_the_interface_files(
    share: Path, idl_alone: Path
) -> None:
    every = [name for name in names(share) if name.startswith("test_msgs/")]
    one, other = (model_of(includes(every), each) for each in (share, idl_alone))
    compared = 0
    for declaration in one.declarations:
        if isinstance(declaration, Struct):
            struct = other.find(declaration.name)
            assert isinstance(struct, Struct)
            for mine, theirs in zip(declaration.members, struct.members, strict=True):
                assert mine.initial == theirs.initial
                assert mine.type == theirs.type
                compared += mine.initial is not None
        elif isinstance(declaration, Const):
            constant = other.find(declaration.name)
            assert isinstance(constant, Const)
            assert constant.value == declaration.value
    assert compared > 50


def test_an_installed_action_is_a_port(
    share: Path,
    idl_alone: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Both forms give the same generated files, but for the layout of some comments."""
    generated = []
    for number, folder in enumerate((share, idl_alone)):
        project = tmp_path / str(number)
        project.mkdir()
        monkeypatch.chdir(project)
        Path("t.idl").write_text(
            '#include "test_msgs/action/Fibonacci.idl"\n'
            "component Counter {\n"
            '  @port("count") provides test_msgs::action::Fibonacci goals;\n'
            '  @port("count") uses test_msgs::action::Fibonacci_Events events;\n'
            "};\n"
        )
        Path("rtgen.toml").write_text(
            f'[sources]\npaths = ["t.idl"]\ninclude = ["{folder.as_posix()}"]\n'
        )
        assert run(["generate", "-q", "--no-cache"]) == 0
        assert run(["check", "-q"]) == 0
        files = Path("generated").rglob("*.py")
        generated.append({str(path): path.read_text() for path in files})
    assert capfd.readouterr().err == ""
    assert any("counter" in name for name in generated[0])
    assert generated[0].keys() == generated[1].keys()


@pytest.mark.parametrize("form", ["all files", "IDL alone"])
def test_packages_as_sources(
    form: str, share: Path, idl_alone: Path, tmp_path: Path
) -> None:
    """Each interface is read once, from the file that its IDL was generated from, if any."""
    folder = tmp_path / "share"
    shutil.copytree(share if form == "all files" else idl_alone, folder)
    for name in BY_HAND:
        (folder / f"test_msgs/msg/{name}.idl").unlink(missing_ok=True)
    result = api.read(folder)
    assert not [d for d in result.diagnostics if d.severity is not Severity.NOTE]
    found = {"/".join(d.name) for d in result.model.declarations}
    assert "test_msgs/msg/WStrings" in found
    suffixes = {Path(file.name).suffix for file in result.model.files if file.main}
    kinds = {f".{kind}" for kind in KINDS}
    assert suffixes == (kinds if form == "all files" else {".idl"})


def test_a_message_with_one_that_is_idl_alone(idl_alone: Path, tmp_path: Path) -> None:
    path = tmp_path / "lab" / "msg" / "Mine.msg"
    path.parent.mkdir(parents=True)
    path.write_text("std_msgs/String[] texts\ntest_msgs/WStrings more\n")
    result = api.read(path, include=[idl_alone])
    assert not result.diagnostics
    assert result.model.find(("test_msgs", "msg", "WStrings"))
