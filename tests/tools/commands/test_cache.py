"""The cache of whole runs."""

from __future__ import annotations

import os
from hashlib import sha256
from importlib import metadata
from pathlib import Path

import platformdirs
import pytest
from msgspec.structs import replace
from small_pipeline import Pipeline

import rtgen
from rtgen.cli import run
from rtgen.compiler.kit import own_files, plugins, stored_files
from rtgen.compiler.project import Project, cache, load, with_arguments
from rtgen.compiler.project.compilation import Compilation
from rtgen.tools.compiling.cached import build


def project(*paths: str) -> Project:
    return with_arguments(load(), paths=paths or ["a.idl", "b.idl"], include=["inc"])


def entries(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "cache").rglob("*.json"))


def test_a_second_run_reads_nothing_and_gives_the_same(pipeline: Pipeline) -> None:
    pipeline.warn = True
    first = build(project(), cache.default())
    second = build(project(), cache.default())
    assert pipeline.reads == 1
    assert second == first
    assert [d.hint for d in second.diagnostics] == ["so", "so"]


def test_without_cache_everything_is_read(pipeline: Pipeline, tmp_path: Path) -> None:
    build(project(), None)
    build(project(), None)
    assert pipeline.reads == 2
    assert entries(tmp_path) == []


def test_a_changed_input_is_read_again(pipeline: Pipeline) -> None:
    build(project(), cache.default())
    Path("b.idl").write_text("2")
    changed = build(project(), cache.default())
    assert pipeline.reads == 2
    Path("b.idl").write_text("two\n")
    assert build(project(), cache.default()).inputs != changed.inputs


def test_a_file_that_appears_where_one_was_looked_for(pipeline: Pipeline) -> None:
    build(project(), cache.default())
    Path("inc").mkdir()
    Path("inc/missing.idl").write_text("")
    build(project(), cache.default())
    assert pipeline.reads == 2


def test_a_link_to_the_same_text_is_read_again(pipeline: Pipeline) -> None:
    """Generated files name a definition by where it is, not by a link to it."""
    build(project(), cache.default())
    Path("b.idl").rename("elsewhere.idl")
    Path("b.idl").symlink_to("elsewhere.idl")
    build(project(), cache.default())
    build(project(), cache.default())
    assert pipeline.reads == 2


@pytest.mark.parametrize(
    "change",
    [
        {"package": "others"},
        {"define": (("A", "1"),)},
        {"skeletons": Path("/elsewhere/mine")},
        {"sources": (Path("b.idl"), Path("a.idl"))},
        {"include": ()},
    ],
)
def test_other_options_are_another_entry(
    pipeline: Pipeline, change: dict[str, object]
) -> None:
    build(project(), cache.default())
    build(replace(project(), **change), cache.default())  # type: ignore[arg-type]
    assert pipeline.reads == 2


def test_another_output_folder_is_the_same_entry(pipeline: Pipeline) -> None:
    build(project(), cache.default())
    build(with_arguments(project(), output="there"), cache.default())
    assert pipeline.reads == 1


def test_runs_with_errors_are_not_kept(pipeline: Pipeline, tmp_path: Path) -> None:
    Path("a.idl").write_text("error\n")
    assert build(project(), cache.default()).failed
    assert entries(tmp_path) == []


@pytest.mark.parametrize(
    "damage",
    [
        "empty",
        "cut",
        "changed",
        "binary",
        "folder",
        "pipe",
        "large",
        "[]",
        "{}",
        '{"artifacts": [[1]]}',
    ],
)
def test_a_damaged_entry_is_ignored(
    pipeline: Pipeline, tmp_path: Path, damage: str
) -> None:
    first = build(project(), cache.default())
    [entry] = entries(tmp_path)
    data = entry.read_bytes()
    entry.unlink()
    match damage:
        case "empty":
            entry.write_bytes(b"")
        case "cut":
            entry.write_bytes(data[: len(data) // 2])
        case "changed":
            entry.write_bytes(data.replace(b"a.idl", b"c.idl", 1))
        case "binary":
            entry.write_bytes(bytes(range(256)))
        case "folder":
            entry.mkdir()
        case "pipe":
            os.mkfifo(entry)
        case "large":
            with entry.open("wb") as stream:
                stream.truncate(2**32)
        case other:
            content = other.encode()
            entry.write_bytes(sha256(content).hexdigest().encode() + b"\n" + content)
    second = build(project(), cache.default())
    assert pipeline.reads == 2
    assert second.artifacts == first.artifacts


def test_a_folder_that_cannot_be_written_is_passed_over(
    pipeline: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "file"))
    assert not build(project(), cache.default()).failed


def test_an_entry_that_another_user_could_have_written_is_not_read(
    pipeline: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    build(project(), cache.default())
    [entry] = entries(tmp_path)
    assert (entry.stat().st_mode & 0o777, entry.parent.stat().st_mode & 0o777) == (
        0o600,
        0o700,
    )
    for path, mode in ((entry, 0o620), (entry.parent, 0o770), (entry, 0o602)):
        path.chmod(mode)
        reads = pipeline.reads
        build(project(), cache.default())
        assert pipeline.reads == reads + 1
        build(project(), cache.default())
        assert pipeline.reads == reads + 1, "stored anew, and closed to others"
    monkeypatch.setattr(os, "geteuid", lambda: entry.stat().st_uid + 1)
    build(project(), cache.default())
    build(project(), cache.default())
    assert pipeline.reads == reads + 3, "the folder of another user is left alone"


def test_files_of_others_in_the_folder_are_left_alone(
    pipeline: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The folder may be a link to one with other files: only entries are removed."""
    monkeypatch.setattr(stored_files, "MAX_BYTES", 10)
    documents = tmp_path / "documents"
    documents.mkdir()
    (documents / "thesis.json").write_text("years of work")
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache" / "runs").symlink_to(documents)
    build(project(), cache.default())
    assert [file.name for file in documents.iterdir()] == ["thesis.json"]


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="needs root")
def test_a_link_of_another_user_is_not_followed(
    pipeline: Pipeline, tmp_path: Path
) -> None:
    documents = tmp_path / "documents"
    documents.mkdir(mode=0o750)
    (tmp_path / "cache").mkdir()
    link = tmp_path / "cache" / "runs"
    link.symlink_to(documents)
    os.lchown(link, 12345, 12345)
    build(project(), cache.default())
    assert list(documents.iterdir()) == []
    assert documents.stat().st_mode & 0o777 == 0o750


def test_the_number_of_entries_is_bounded(
    pipeline: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stored_files, "_MAX_FILES", 3)
    for number in range(6):
        build(replace(project(), package=f"p{number}"), cache.default())
        for age, entry in enumerate(entries(tmp_path)):
            os.utime(entry, ns=(age, age))
    assert len(entries(tmp_path)) == 3


def test_the_size_is_bounded(
    pipeline: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stored_files, "MAX_BYTES", 10)
    build(project(), cache.default())
    assert entries(tmp_path) == []


def test_the_key_tells_plug_ins_and_their_content(
    pipeline: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module = tmp_path / "some_plugin.py"
    module.write_text("BACKEND = None\n")
    monkeypatch.syspath_prepend(tmp_path)
    plugin = metadata.EntryPoint("x", "some_plugin:BACKEND", plugins.Group.BACKENDS)
    known = cache.default()
    keys = {known.key(project(), ()), known.key(project(), (plugin,))}
    module.write_text("BACKEND = 1\n")
    keys.add(known.key(project(), (plugin,)))
    times = module.stat()
    module.write_text("BACKEND = 2\n")
    os.utime(module, ns=(times.st_atime_ns, times.st_mtime_ns))
    keys.add(known.key(project(), (plugin,)))
    assert len(keys) == 4


@pytest.mark.parametrize("base", ["", "{}/base", "relative"])
def test_the_users_folder_is_the_default(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, base: str
) -> None:
    monkeypatch.delenv("RTGEN_CACHE_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_CACHE_HOME", base.format(tmp_path))
    cache.default().store("key", Compilation((), {}, (), {}))
    folder = Path(platformdirs.user_cache_dir("rtgen", appauthor=False))
    assert folder.is_relative_to(tmp_path)
    assert (folder / "runs" / "key.json").is_file()


def test_what_inspect_prints_is_kept_too(
    pipeline: Pipeline, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    pipeline.warn = True
    command = ["inspect", "--json", "a.idl", "-I", "inc"]
    results = [(run(command), *capfd.readouterr()) for _ in range(2)]
    assert pipeline.reads == 1
    assert results[0] == results[1]
    assert "IDL0998" in results[0][2]
    assert run(command[:1] + command[2:]) == 0
    assert pipeline.reads == 2
    assert len(entries(tmp_path)) == 2


def test_inspect_without_cache(pipeline: Pipeline, tmp_path: Path) -> None:
    assert run(["inspect", "--json", "--no-cache", "a.idl"]) == 0
    assert entries(tmp_path) == []


def test_a_file_that_hides_an_included_one_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    for folder in ("first", "second"):
        Path(folder).mkdir()
    Path("main.idl").write_text('#include "part.idl"\n', encoding="latin-1")
    Path("second/part.idl").write_text("struct Old { long a; }; ; // \xe9\n", "latin-1")
    command = ["inspect", "main.idl", "-I", "first", "-I", "second"]
    results = [(run(command), *capfd.readouterr()) for _ in range(2)]
    assert results[0] == results[1]
    assert "\xe9" in results[0][2]
    Path("first/part.idl").write_text("struct New { long a; };\n")
    assert run(command) == 0
    assert "struct New" in capfd.readouterr().out


def test_a_key_depends_on_every_file_of_the_compiler() -> None:
    """Also on those of packages beside the cache's own."""
    found = {
        path.relative_to(folder).as_posix()
        for path in map(Path, own_files.stamp(own_files.compiler_folders()).split("\0"))
        for folder in map(Path, rtgen.__path__)
        if path.is_relative_to(folder)
    }
    assert found >= {
        "compiler/compilation.py",
        "compiler/backends/kit/python_text.py",
        "compiler/frontends/idl/pipeline.py",
        "facts/idl_files.py",
        "ros2/rosidl/pipeline.py",
        "templates/components/base.py.j2",
    }
    assert not any(path.startswith(("runtime/", "cli/")) for path in found)
