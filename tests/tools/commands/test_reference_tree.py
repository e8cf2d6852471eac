"""The whole reference build in processes of its own: the same bytes, also if killed or cached."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rtgen.cli import run

ROOT = Path(__file__).resolve().parents[3]
RTGEN = [sys.executable, "-m", "rtgen"]


def copy_of_specs(folder: Path) -> Path:
    """Return the definitions and project file of the reference build, without generated files."""
    folder.mkdir(parents=True)
    shutil.copytree(ROOT / "specs", folder / "specs")
    shutil.copy(ROOT / "rtgen.toml", folder)
    return folder


def environment(tmp_path: Path, **changes: str) -> dict[str, str]:
    return os.environ | {"RTGEN_CACHE_DIR": str(tmp_path / "cache")} | changes


def rtgen(folder: Path, environment: dict[str, str], *arguments: str) -> str:
    done = subprocess.run(
        [*RTGEN, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def tree(folder: Path) -> dict[str, bytes]:
    return {
        file.relative_to(folder).as_posix(): file.read_bytes()
        for place in ("generated", "src")
        for file in sorted((folder / place).rglob("*"))
        if file.is_file() and "__pycache__" not in file.parts
    }


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a project with the reference build."""
    place = tmp_path_factory.mktemp("built")
    folder = copy_of_specs(place / "a")
    rtgen(folder, environment(place), "generate")
    return folder


@pytest.mark.nightly
def test_the_same_bytes_whatever_locale_hash_seed_and_folder(tmp_path: Path) -> None:
    settings = [
        {
            "LC_ALL": "C",
            "PYTHONHASHSEED": "1",
            "PYTHONUTF8": "0",
            "PYTHONCOERCECLOCALE": "0",
        },
        {"LC_ALL": "ja_JP.eucJP", "PYTHONHASHSEED": "77", "TZ": "Asia/Tokyo"},
        {"LC_ALL": "C.UTF-8", "PYTHONHASHSEED": "0"},
    ]
    names = ("a", "b c/ä", "b c/deep/er")
    trees = []
    for name, changes in zip(names, settings, strict=True):
        folder = copy_of_specs(tmp_path / name)
        rtgen(folder, environment(tmp_path, **changes), "generate", "--no-cache")
        trees.append(tree(folder))
    assert trees[0] == trees[1] == trees[2]
    committed = tree(ROOT)
    made = {n: data for n, data in trees[0].items() if n.startswith("generated/")}
    assert made == {
        n: data for n, data in committed.items() if n.startswith("generated/")
    }


@pytest.mark.sampled(0)
def test_no_file_says_where_or_when_it_was_made(built: Path) -> None:
    for name, data in tree(built).items():
        assert str(built.parent).encode() not in data, name


@pytest.mark.nightly
def test_the_committed_tree_is_what_the_definitions_give(tmp_path: Path) -> None:
    assert rtgen(ROOT, environment(tmp_path), "check", "--no-cache") == ""


@pytest.mark.nightly
def test_a_run_from_the_cache_loads_neither_front_ends_nor_back_ends(
    tmp_path: Path,
) -> None:
    code = (
        "import sys; from rtgen.cli import run; code = run(['check']);"
        "heavy = {'lark', 'jinja2', 'rich', 'lxml', 'rtgen.compiler.model', 'rtgen.runtime'};"
        "print(code, sorted(heavy & set(sys.modules)))"
    )
    outputs = [
        subprocess.run(
            [sys.executable, "-c", code],
            cwd=ROOT,
            env=environment(tmp_path),
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(2)
    ]
    assert "rtgen.compiler.model" in outputs[0]
    assert outputs[1] == "0 []\n"


@pytest.mark.nightly
def test_a_kill_in_the_middle_leaves_whole_files(built: Path, tmp_path: Path) -> None:
    folder = tmp_path / "a"
    shutil.copytree(built, folder)
    settings = environment(tmp_path)
    old = tree(folder)
    definition = folder / "specs" / "idl" / "intellirobot.idl"
    text = definition.read_text(encoding="utf-8")
    definition.write_text(text + "\n// another text, another hash\n", encoding="utf-8")
    rtgen(folder, settings, "generate", "-o", "new")
    new = tree(folder / "new")
    chance = random.Random(3)
    for _ in range(4):
        process = subprocess.Popen([*RTGEN, "generate"], cwd=folder, env=settings)
        try:
            process.wait(chance.uniform(0.05, 0.4))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
        there = tree(folder)
        for name, data in there.items():
            if not Path(name).name.startswith(".rtgen-"):
                assert data in (old.get(name), new.get(name)), name
        shutil.rmtree(folder / "generated")
        for name, data in old.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
    rtgen(folder, settings, "generate")
    made = {n: d for n, d in tree(folder).items() if n.startswith("generated/")}
    assert made == {n: d for n, d in new.items() if n.startswith("generated/")}


@pytest.mark.nightly
def test_one_character_anywhere_in_the_tree_is_drift(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = copy_of_specs(tmp_path / "a")
    monkeypatch.chdir(folder)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    assert run(["generate"]) == 0
    made = folder / "generated"
    manifest = made / ".rtgen.json"
    owned = {*(made / f for f in json.loads(manifest.read_text())["files"])}
    skeletons = sorted(
        {*(folder / "reference").rglob("*.py"), *made.rglob("*Client.py")}
    )
    assert owned.isdisjoint(skeletons)
    assert manifest not in owned
    for file in skeletons:
        file.write_text("# mine alone\n")
    chance = random.Random(5)

    def assert_drift(*changed: Path) -> None:
        """Check that `check` reports each file with a changed character."""
        good = {file: file.read_bytes() for file in changed}
        for file, data in good.items():
            at = chance.randrange(len(data)) if data else 0
            file.write_bytes(data[:at] + b"\x07" + data[at + 1 :])
        capfd.readouterr()
        assert run(["check"]) == 1, changed
        out, err = capfd.readouterr()
        for file, data in good.items():
            name = file.relative_to(folder).as_posix()
            # The manifest is a table of hashes: it is reported in words.
            head = f"--- a/{name}\n+++ b/{name}\n@@ "
            assert f"{name} is missing or damaged" in err or head in out, name
            file.write_bytes(data)

    assert_drift(manifest)
    assert_drift(*sorted(owned))
    for file in chance.sample(sorted(owned), 10):
        assert_drift(file)
    assert run(["check", "--only", "drift"]) == 0
    assert run(["generate"]) == 0
    assert {file.read_text() for file in skeletons} == {"# mine alone\n"}


@pytest.mark.sampled(1)
@pytest.mark.parametrize("kind", ["json", "tree"])
def test_inspect_shows_all_components(tmp_path: Path, kind: str) -> None:
    options = ["--json"] if kind == "json" else []
    out = rtgen(ROOT, environment(tmp_path), "inspect", "specs/navigation", *options)
    names = (
        "Navigation",
        "Odometry",
        "OmniTo2WD",
        "PathFollower",
        "PositionInput",
        "RefHardRh3",
    )
    if kind == "json":
        kinds = {d["name"]: d["kind"] for d in json.loads(out)["declarations"]}
        assert all(kinds[name] == "component" for name in names)
    else:
        assert all(f"  component {name}\n" in out for name in names)
