"""The output folder: files written, left unchanged, and refused."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

import pytest

from rtgen.compiler.backends import Artifact, ComponentTypes, Owner
from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.compiler.project import Project, output
from rtgen.compiler.project.compilation import Compilation

INPUTS = {"a.idl": "0" * 64}


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return Project(
        root=tmp_path,
        base=tmp_path,
        output=tmp_path / "generated",
        skeletons=tmp_path / "src" / "mine",
    )


def artifacts(*paths: str, text: str = "text\n") -> list[Artifact]:
    return [Artifact(path, text, ("a.idl",)) for path in paths]


def skeleton(path: str) -> Artifact:
    return Artifact(path, "skeleton\n", ("a.idl",), Owner.USER)


def snapshot(folder: Path) -> dict[str, tuple[int, int, bytes]]:
    """Return inode, time and content of every file."""
    return {
        file.relative_to(folder).as_posix(): (
            file.stat().st_ino,
            file.stat().st_mtime_ns,
            file.read_bytes(),
        )
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def codes(error: pytest.ExceptionInfo[InputError]) -> list[str]:
    return [d.code for d in error.value.diagnostics]


def test_the_second_write_does_nothing(project: Project) -> None:
    made = [*artifacts("p/a.py", "p/b.py"), skeleton("mine.py")]
    first = output.write(project, Compilation(made, INPUTS))
    assert [c.path.name for c in first.changes] == [".rtgen.json", "a.py", "b.py"]
    assert (project.skeletons / "mine.py").read_text() == "skeleton\n"
    before = snapshot(project.root)
    second = output.write(project, Compilation(made, INPUTS))
    assert second.empty
    assert second.unchanged == 3
    assert snapshot(project.root) == before


def test_a_changed_file_alone_is_written(project: Project) -> None:
    output.write(project, Compilation(artifacts("p/a.py", "p/b.py"), INPUTS))
    before = snapshot(project.output)
    (project.output / "p" / "b.py").write_text("edited\n")
    done = output.write(project, Compilation(artifacts("p/a.py", "p/b.py"), INPUTS))
    assert [c.path.name for c in done.changes] == ["b.py"]
    after = snapshot(project.output)
    assert after["p/a.py"] == before["p/a.py"]
    assert after["p/b.py"][2] == b"text\n"


def test_the_manifest_names_every_file_with_its_hash_and_inputs(
    project: Project,
) -> None:
    output.write(
        project, Compilation([*artifacts("p/a.py"), skeleton("mine.py")], INPUTS)
    )
    manifest = json.loads((project.output / ".rtgen.json").read_text())
    assert manifest["inputs"] == INPUTS
    digest = sha256(b"text\n").hexdigest()
    assert manifest["files"] == {"p/a.py": {"sha256": digest, "inputs": ["a.idl"]}}
    assert str(project.root) not in json.dumps(manifest)


def test_the_manifest_has_the_component_types(project: Project) -> None:
    types = ComponentTypes(
        {"Motor": "mine.motor:Motor", "Arm": "mine.arm:Arm"}, {"Arm": "C++"}
    )
    output.write(project, Compilation(artifacts("p/a.py"), INPUTS, components=types))
    manifest = json.loads((project.output / ".rtgen.json").read_text())
    assert list(manifest["factories"]) == ["Arm", "Motor"]
    assert output.component_types(project.output) == types
    assert output.plan(
        project, Compilation(artifacts("p/a.py"), INPUTS, components=types)
    ).empty
    other = ComponentTypes({**types.factories, "Motor": "other:Motor"}, types.languages)
    planned = output.plan(
        project, Compilation(artifacts("p/a.py"), INPUTS, components=other)
    )
    assert [c.path.name for c in planned.changes] == [".rtgen.json"]


def test_without_component_types_the_manifest_has_no_table(project: Project) -> None:
    output.write(project, Compilation(artifacts("p/a.py"), INPUTS))
    manifest = json.loads((project.output / ".rtgen.json").read_text())
    assert list(manifest) == ["format", "generator", "inputs", "files"]
    assert output.component_types(project.output) == ComponentTypes()
    assert output.component_types(project.root / "nowhere") == ComponentTypes()


@pytest.mark.skipif(sys.platform == "win32", reason="no named pipes")
def test_a_pipe_in_the_place_of_the_manifest_is_not_read(project: Project) -> None:
    project.output.mkdir()
    os.mkfifo(project.output / ".rtgen.json")
    with pytest.raises(ToolError, match="is not a regular file"):
        output.component_types(project.output)


def test_of_types_of_one_name_the_first_counts() -> None:
    first = ComponentTypes({"A": "a:A"})
    second = ComponentTypes({"A": "b:A", "B": "b:B"}, {"A": "C", "B": "C++"})
    both = first.joined(second)
    assert both == ComponentTypes({"A": "a:A", "B": "b:B"}, {"B": "C++"})


def test_what_is_no_longer_made_is_removed_with_its_empty_folders(
    project: Project,
) -> None:
    output.write(project, Compilation(artifacts("p/old/a.py", "p/b.py"), INPUTS))
    bytecode = project.output / "p" / "old" / "__pycache__"
    bytecode.mkdir()
    (bytecode / "a.cpython-311.pyc").write_bytes(b"")
    output.write(project, Compilation(artifacts("p/b.py"), INPUTS))
    assert not (project.output / "p" / "old").exists()
    assert (project.output / "p" / "b.py").exists()


def test_what_a_gitignore_among_the_files_names_is_no_stray(project: Project) -> None:
    ignored = Artifact("p/.gitignore", "# made elsewhere\nstubs/\n*.log\n", ("a.idl",))
    made = [*artifacts("p/a.py"), ignored]
    output.write(project, Compilation(made, INPUTS))
    others = ["p/stubs/RTC/__init__.py", "p/q/stubs/x.py", "p/q/rtc12.log"]
    strays = ["stubs/x.py", "rtc12.log", "p/q/log", "p/q/x.py"]
    for name in (*others, *strays):
        path = project.output / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("theirs")
    planned = output.plan(project, Compilation(made, INPUTS))
    assert planned.strays == tuple(project.output / name for name in sorted(strays))
    assert planned.changes == ()


def test_a_stray_file_is_reported_and_left(project: Project) -> None:
    output.write(project, Compilation(artifacts("p/a.py"), INPUTS))
    stray = project.output / "p" / "notes.txt"
    stray.write_text("mine")
    (project.output / "p" / "__pycache__").mkdir()
    (project.output / "p" / "__pycache__" / "a.pyc").write_bytes(b"")
    done = output.write(project, Compilation(artifacts("q/a.py"), INPUTS))
    assert done.strays == (stray,)
    assert stray.read_text() == "mine"


def test_an_edited_skeleton_survives(project: Project) -> None:
    output.write(project, Compilation([skeleton("mine.py")], INPUTS))
    file = project.skeletons / "mine.py"
    file.write_text("my own work\n")
    output.write(
        project, Compilation([*artifacts("a.py"), skeleton("mine.py")], INPUTS)
    )
    assert file.read_text() == "my own work\n"
    output.write(project, Compilation([], INPUTS))
    assert file.read_text() == "my own work\n"


def test_a_skeleton_that_is_a_dangling_link_is_left_alone(project: Project) -> None:
    project.skeletons.mkdir(parents=True)
    (project.skeletons / "mine.py").symlink_to(project.root / "nowhere")
    output.write(project, Compilation([skeleton("mine.py")], INPUTS))
    assert not (project.root / "nowhere").exists()
    assert (project.skeletons / "mine.py").is_symlink()


@pytest.mark.parametrize(
    "path",
    [
        "../x.py",
        "/etc/x.py",
        "p/../../x.py",
        "p//x.py",
        "",
        ".",
        "p/.",
        "..",
        "p\\x.py",
        "c:x.py",
        "p/\0.py",
        "p/\n.py",
        ".rtgen.json",
        ".rtgen-1.tmp",
        "p/",
    ],
)
@pytest.mark.parametrize("owner", list(Owner))
def test_a_path_that_leaves_its_folder_is_refused(
    project: Project, path: str, owner: Owner
) -> None:
    made = [*artifacts("fine.py"), Artifact(path, "x", ("a.idl",), owner)]
    with pytest.raises(InputError) as error:
        output.write(project, Compilation(made, INPUTS))
    assert codes(error) == ["PRJ0102"]
    assert not any(project.root.iterdir())


def test_a_name_that_no_file_system_takes_is_refused(project: Project) -> None:
    with pytest.raises(InputError) as error:
        output.write(project, Compilation(artifacts("ü" * 128), INPUTS))
    assert codes(error) == ["PRJ0105"]


def test_a_lone_surrogate_is_refused(project: Project) -> None:
    with pytest.raises(InputError) as error:
        output.write(project, Compilation(artifacts("a.py", text="\ud800"), INPUTS))
    assert codes(error) == ["PRJ0104"]


@pytest.mark.parametrize(
    "paths",
    [
        ("p/a.py", "p/a.py"),
        ("p/a.py", "p/A.py"),
        ("p", "p/a.py"),
        ("p/a.py", "p"),
        ("p/q/r", "P"),
        ("p/caf\u00e9", "p/Cafe\u0301"),
    ],
)
def test_two_artifacts_of_one_path_are_refused(
    project: Project, paths: tuple[str, ...]
) -> None:
    with pytest.raises(InputError) as error:
        output.write(project, Compilation(artifacts(*paths), INPUTS))
    assert codes(error) == ["PRJ0101"]
    assert "a.idl" in error.value.diagnostics[0].message


def test_rtgen_and_a_user_may_have_files_of_one_name(project: Project) -> None:
    output.write(project, Compilation([*artifacts("a.py"), skeleton("a.py")], INPUTS))
    assert (project.output / "a.py").exists()
    assert (project.skeletons / "a.py").exists()


@pytest.mark.parametrize(
    "place", ["generated", "generated/p", "generated/p/a.py", "src/mine"]
)
def test_links_out_of_the_folder_are_refused(
    project: Project, tmp_path_factory: pytest.TempPathFactory, place: str
) -> None:
    outside = tmp_path_factory.mktemp("outside")
    target = outside / "a.py"
    target.write_text("not rtgen's\n")
    link = project.root / place
    link.parent.mkdir(parents=True, exist_ok=True)
    link.symlink_to(target if place.endswith(".py") else outside)
    with pytest.raises(InputError) as error:
        output.write(
            project, Compilation([*artifacts("p/a.py"), skeleton("s.py")], INPUTS)
        )
    assert set(codes(error)) == {"PRJ0103"}
    assert {f.name: f.read_text() for f in outside.iterdir()} == {
        "a.py": "not rtgen's\n"
    }


def test_a_manifest_that_names_files_elsewhere_removes_nothing_there(
    project: Project,
) -> None:
    precious = project.root / "precious.txt"
    precious.write_text("keep")
    project.output.mkdir()
    files = {"../precious.txt": {}, str(precious): {}, "gone.py": {}}
    (project.output / ".rtgen.json").write_text(json.dumps({"files": files}))
    output.write(project, Compilation(artifacts("a.py"), INPUTS))
    assert precious.read_text() == "keep"


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"files": 3}', '{"files": [3]}', "[" * 9999]
)
def test_a_damaged_manifest_is_made_anew(project: Project, text: str) -> None:
    output.write(project, Compilation(artifacts("a.py"), INPUTS))
    manifest = project.output / ".rtgen.json"
    good = manifest.read_bytes()
    manifest.write_text(text)
    done = output.write(project, Compilation(artifacts("a.py"), INPUTS))
    assert [c.path for c in done.changes] == [manifest]
    assert manifest.read_bytes() == good


def test_a_folder_in_the_place_of_a_file(project: Project) -> None:
    (project.output / "a.py").mkdir(parents=True)
    (project.output / "a.py" / "mine").write_text("")
    with pytest.raises(ToolError, match=r"a\.py"):
        output.write(project, Compilation(artifacts("a.py"), INPUTS))
    assert (
        output.plan(project, Compilation(artifacts("a.py"), INPUTS))
        .changes[-1]
        .obstacle
    )


def test_folders_that_nothing_is_in_are_removed(project: Project) -> None:
    output.write(project, Compilation(artifacts("a.py"), INPUTS))
    (project.output / "b" / "c").mkdir(parents=True)
    (project.output / "b" / "__pycache__").mkdir()
    done = output.write(project, Compilation(artifacts("a.py"), INPUTS))
    assert [f.name for f in done.barren] == ["c", "b"]
    assert not (project.output / "b").exists()


def test_a_file_in_the_place_of_a_folder(project: Project) -> None:
    output.write(project, Compilation(artifacts("p"), INPUTS))
    output.write(project, Compilation(artifacts("p/a.py"), INPUTS))
    assert (project.output / "p" / "a.py").is_file()
    output.write(project, Compilation(artifacts("p"), INPUTS))
    assert (project.output / "p").is_file()


def test_leftovers_of_a_killed_run_are_removed(project: Project) -> None:
    output.write(project, Compilation([*artifacts("p/a.py"), skeleton("s.py")], INPUTS))
    leftovers = [
        project.output / "p" / ".rtgen-7.tmp",
        project.skeletons / ".rtgen-9.tmp",
    ]
    for leftover in leftovers:
        leftover.write_text("half")
    done = output.write(
        project, Compilation([*artifacts("p/a.py"), skeleton("s.py")], INPUTS)
    )
    assert sorted(done.leftovers) == sorted(leftovers)
    assert not any(f.exists() for f in leftovers)


def test_a_failing_disk_leaves_the_old_file_and_no_leftover(
    project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    output.write(project, Compilation(artifacts("a.py"), INPUTS))

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ToolError, match="No space left"):
        output.write(project, Compilation(artifacts("a.py", text="new\n"), INPUTS))
    assert (project.output / "a.py").read_text() == "text\n"
    assert not list(project.output.glob(".rtgen-*"))


WRITER = """
import sys
from pathlib import Path
from rtgen.compiler.project import output
from rtgen.compiler.backends import Artifact
from rtgen.compiler.project import Project
from rtgen.compiler.project.compilation import Compilation
root = Path(sys.argv[1])
project = Project(root=root, base=root, output=root / "generated", skeletons=root / "src")
version = int(sys.argv[2])
print("ready", flush=True)
while True:
    version += 1
    names = [f"p{(i + version) % 12}/f.txt" for i in range(8)]
    text = f"{version % 2}" * 20000
    made = [Artifact(n, text, ("a.idl",)) for n in names]
    output.write(project, Compilation(made, {"a.idl": str(version)}))
"""


def _run_and_kill(root: Path, version: int, seconds: float) -> None:
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(root), str(version)], stdout=subprocess.PIPE
    )
    assert writer.stdout is not None
    assert writer.stdout.readline() == b"ready\n"
    with writer:
        try:
            writer.wait(seconds)
        except subprocess.TimeoutExpired:
            writer.send_signal(signal.SIGKILL)
    assert writer.returncode == -signal.SIGKILL


def test_a_kill_leaves_the_old_file_or_the_new_one(project: Project) -> None:
    whole: Mapping[bytes, bytes] = {b"0": b"0" * 20000, b"1": b"1" * 20000}
    chance = random.Random(1)
    for version in range(8):
        _run_and_kill(project.root, version, chance.uniform(0.0, 0.08))
        manifest = project.output / ".rtgen.json"
        known = json.loads(manifest.read_text())["files"] if manifest.exists() else {}
        for file in sorted(project.output.rglob("*.txt")):
            data = file.read_bytes()
            assert data == whole[data[:1]]
            assert file.relative_to(project.output).as_posix() in known
    output.write(project, Compilation(artifacts("a.py"), INPUTS))
    assert sorted(f.name for f in project.output.rglob("*")) == [".rtgen.json", "a.py"]


@pytest.mark.sampled(0)
def test_runs_at_the_same_time_leave_the_tree_of_one(project: Project) -> None:
    script = WRITER.replace("while True", "for _ in range(6)")
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", script, str(project.root), str(version)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        for version in (0, 100, 200, 300, 400)
    ]
    for writer in writers:
        _, errors = writer.communicate()
        assert writer.returncode == 0, errors.decode()
    manifest = json.loads((project.output / ".rtgen.json").read_text())
    files = {
        f.relative_to(project.output).as_posix() for f in project.output.rglob("*.txt")
    }
    assert files == set(manifest["files"])
    assert len({f.read_bytes() for f in project.output.rglob("*.txt")}) == 1


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("mine\n", "PRJ0106"),
        ("", "PRJ0106"),
        ("# Generated by rtgen 0.0.1 from x.idl.\nold\n", None),
        ("text\n", None),
    ],
)
def test_a_file_that_rtgen_did_not_make_stays(
    project: Project, text: str, code: str | None
) -> None:
    there = project.output / "robots" / "a.py"
    there.parent.mkdir(parents=True)
    there.write_text(text, encoding="utf-8")
    wanted = artifacts("robots/a.py", "robots/b.py")
    if code is None:
        output.write(project, Compilation(wanted, INPUTS))
        assert there.read_text(encoding="utf-8") == "text\n"
        return
    before = snapshot(project.output)
    for action in (output.plan, output.write):
        with pytest.raises(InputError) as error:
            action(project, Compilation(wanted, INPUTS))
        assert codes(error) == [code]
        assert "robots/a.py would be overwritten" in str(error.value.diagnostics)
    assert snapshot(project.output) == before
