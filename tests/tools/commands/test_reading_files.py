"""Files of the user: one reader, of regular files up to a size, and one writer."""

from __future__ import annotations

import ast
import os
import re
import socket
import stat
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from rtgen_sources import trees

from rtgen.facts.files import (
    ChangedError,
    UnreadableError,
    check_file,
    check_output,
    create_file,
    is_file,
    open_file,
    read_file,
    read_start,
    replace_file,
)

OWN_FILES = {
    "compiler/backends/canopen/shared_files.py _shared_idl",
    "compiler/backends/kit/compiled_templates.py _compiler",
    "compiler/backends/kit/rendering.py template_source",
    "compiler/backends/small/backend.py _Tree.artifacts",
    "compiler/backends/typescript/backend.py _Tree.artifacts",
    "compiler/diagnostics/rules.py _page",
    "compiler/diagnostics/rules.py _hints",
    "tools/docs/site.py _settings",
    "tools/docs/site.py site",
    "compiler/frontends/idl/library.py dependencies",
    "compiler/frontends/kit/grammars.py load",
    "compiler/frontends/kit/lalr_tables.py write",
    "compiler/kit/resources.py idl_source",
    "compiler/kit/resources.py rh3_source",
    "compiler/kit/resources.py ros_source",
    "compiler/kit/resources.py usual_units",
    "ui/server.py _file.serve",
    "ui/server.py _index.serve",
}
"""Readers of files that are installed with rtgen."""

WRITERS = {
    "cli/__init__.py _unwritable",
    "tools/components/conversion.py Converted.write",
    "tools/docs/building.py build",
    "tools/kit/console.py discard_unread",
    "cli/lsp.py lsp",
    "tools/running/trajectory.py _check_writable",
    "ui/stored_tokens.py _read",
    "tools/diff/revisions.py _create",
    "tools/fmt/toml.py _formatted",
    "compiler/project/output.py _lock",
    "compiler/project/output.py _sync_folder",
    "compiler/project/output.py _write_whole",
    "runtime/rtc/checkpoints.py CheckpointFile.__init__",
    "tools/renaming/journal.py _locked",
    "tools/renaming/plan.py _write",
    "tools/scaffold/writing.py added",
    "ui/documents/storing.py _create",
}
"""Writers of new files, of outputs that a command names, and of rtgen's own state."""

OTHERS = {
    "__main__.py _open_streams",
    "facts/looks.py digest",
    "compiler/kit/own_files.py read_own",
    "cli/formatting.py Formatter.write_text",
    "cli/help.py write_description",
    "compiler/lowering/profiles/definitions.py Definitions.component",
    "runtime/dds/c_log.py _Log.__init__",
    "runtime/system/monitor.py _activity",
}
"""Functions that read files of the cache, compare the octets of a file with those that a command
read, or open none, or the null device.
"""

_MODE = re.compile(r"[rwaxbt+]{1,3}")
_METHODS = frozenset(("read_text", "read_bytes", "write_text", "write_bytes", "fdopen"))
_TEXT_OPTIONS = frozenset(("mode", "encoding", "errors", "newline"))
_FUNCTIONS = frozenset(("open", "os.open", "io.open", "codecs.open", "tokenize.open"))


def opens(call: ast.Call) -> bool:
    """Return whether a call opens a file by its name, as far as its text shows."""
    name = ast.unparse(call.func)
    _, dot, method = name.rpartition(".")
    if name in _FUNCTIONS or (dot and method in _METHODS):
        return True
    first = call.args[0] if call.args else None
    has_mode = isinstance(first, ast.Constant) and isinstance(first.value, str)
    return method == "open" and (
        any(each.arg in _TEXT_OPTIONS for each in call.keywords)
        or (has_mode and _MODE.fullmatch(ast.literal_eval(first or "")) is not None)
    )


def openers(node: ast.AST, scope: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the functions that open files below a node."""
    for child in ast.iter_child_nodes(node):
        inner = scope
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            inner = (*scope, child.name)
        if isinstance(child, ast.Call) and opens(child):
            yield ".".join(scope)
        yield from openers(child, inner)


def test_files_of_the_user_are_opened_by_one_module() -> None:
    found = {
        f"{name} {function}"
        for name, tree in trees(rf"open\(|\.(?:{'|'.join(_METHODS)})\(")
        if not name.startswith("examples/")
        for function in openers(tree)
    }
    others = {each for each in found if not each.startswith("facts/files.py ")}
    assert others == OWN_FILES | WRITERS | OTHERS


def a_pipe(path: Path) -> None:
    os.mkfifo(path)


def a_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(path.name)


def a_folder(path: Path) -> None:
    path.mkdir()


def zeros(path: Path) -> None:
    path.symlink_to("/dev/zero")


def nothing(path: Path) -> None:
    path.symlink_to("/dev/null")


def a_circle(path: Path) -> None:
    path.symlink_to(path.name)


NO_FILES: dict[Callable[[Path], None], str] = {
    a_pipe: "it is a pipe, not a file",
    a_socket: "it is a socket, not a file",
    a_folder: "it is a folder, not a file",
    zeros: "it is a device, not a file",
    nothing: "it is a device, not a file",
    a_circle: "Too many levels of symbolic links",
}


@pytest.mark.parametrize("linked", [False, True])
@pytest.mark.parametrize("make", NO_FILES, ids=lambda make: make.__name__)
def test_what_is_no_file_is_refused_without_waiting(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    make: Callable[[Path], None],
    linked: bool,
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path("a.idl")
    make(path)
    if linked:
        path = Path("link.idl")
        path.symlink_to("a.idl")
    assert not is_file(path)
    for read in (read_file, open_file, check_file):
        with pytest.raises(OSError, match=NO_FILES[make]) as raised:
            read(path)
        assert raised.value.strerror == NO_FILES[make]
    with pytest.raises(OSError, match=NO_FILES[make]):
        read_start(path, 10)
    with pytest.raises(OSError, match=NO_FILES[make]):
        replace_file(path, b"new", b"")
    with pytest.raises(UnreadableError, match="a path has no null character"):
        read_file(Path("a\0b"))
    assert not is_file(Path("a\0b"))


def test_a_pipe_that_takes_the_place_of_a_file_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.idl"
    path.write_bytes(b"text")
    status = path.stat()
    path.unlink()
    os.mkfifo(path)
    monkeypatch.setattr(Path, "stat", lambda self: status)
    with pytest.raises(UnreadableError, match="it is a pipe, not a file"):
        read_file(path)


def test_large_files_are_read_up_to_a_limit(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as stream:
        stream.truncate(8 << 30)
    with pytest.raises(UnreadableError, match="it is larger than 33,554,432 bytes"):
        read_file(path)
    with pytest.raises(UnreadableError, match="it is larger than 10 bytes"):
        read_file(path, 10)
    with pytest.raises(UnreadableError, match="it is larger than 33,554,432 bytes"):
        check_file(path)
    assert read_start(path, 100_000) == bytes(100_000)
    with open_file(path) as stream:
        assert stream.seek(-1, os.SEEK_END) == (8 << 30) - 1
    path.write_bytes(b"0123456789")
    assert read_file(path, 10) == read_start(path, 10) == b"0123456789"
    assert read_start(path, 3) == b"012"


def test_files_without_a_size_are_read() -> None:
    """The kernel's files are regular, and have the size 0."""
    path = Path("/proc/self/status")
    if not path.exists():
        pytest.skip("no /proc")
    assert b"Name:" in read_file(path)


def test_a_replaced_file_keeps_what_belongs_to_it(tmp_path: Path) -> None:
    file, other, link = (tmp_path / name for name in ("a", "b", "c"))
    file.write_bytes(b"old")
    file.chmod(0o640)
    link.symlink_to("a")
    replace_file(link, b"new", b"old")
    assert link.is_symlink()
    assert file.read_bytes() == b"new"
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    other.hardlink_to(file)
    for content, before in ((b"longer than before", b"new"), (b"s", None)):
        replace_file(file, content, before or file.read_bytes())
        assert other.read_bytes() == content
        assert file.samefile(other)
    assert sorted(tmp_path.iterdir()) == [file, other, link]


@pytest.mark.parametrize("content", [b"", b"old and more", b"ol", b"odl"])
@pytest.mark.parametrize("hard", [False, True])
def test_a_changed_file_is_left_as_it_is(
    tmp_path: Path, content: bytes, hard: bool
) -> None:
    file = tmp_path / "a"
    file.write_bytes(content)
    if hard:
        (tmp_path / "b").hardlink_to(file)
    before = file.stat()
    with pytest.raises(ChangedError, match="it has been changed meanwhile"):
        replace_file(file, b"new", b"old")
    assert file.read_bytes() == content
    assert file.stat().st_mtime_ns == before.st_mtime_ns
    assert {*tmp_path.iterdir()} <= {file, tmp_path / "b"}


def test_what_a_killed_run_has_left_is_used_by_the_next_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a"
    file.write_bytes(b"old")

    def dies(self: Path, target: Path) -> Path:
        os._exit(0)

    child = os.fork()
    if child == 0:
        monkeypatch.setattr(Path, "replace", dies)
        replace_file(file, b"new and longer", b"old")
    os.waitpid(child, 0)
    assert file.read_bytes() == b"old"
    [left] = {*tmp_path.iterdir()} - {file}
    replace_file(file, b"new", b"old")
    assert file.read_bytes() == b"new"
    assert not left.exists()


def test_two_runs_do_not_write_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a"
    file.write_bytes(b"old")
    move = Path.replace

    def meanwhile(self: Path, target: Path) -> Path:
        monkeypatch.setattr(Path, "replace", move)
        with pytest.raises(OSError, match="another run of rtgen is writing it"):
            replace_file(file, b"other", b"old")
        return move(self, target)

    monkeypatch.setattr(Path, "replace", meanwhile)
    replace_file(file, b"new", b"old")
    assert file.read_bytes() == b"new"
    assert [*tmp_path.iterdir()] == [file]


@pytest.mark.parametrize("hard", [False, True])
def test_after_a_failure_the_file_is_as_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hard: bool
) -> None:
    file = tmp_path / "a"
    file.write_bytes(b"old")
    if hard:
        (tmp_path / "b").hardlink_to(file)
    write = os.write

    def full(number: int, data: memoryview) -> int:
        if len(data) < 1_000:
            return write(number, data)
        if len(data) == 100_000:
            return write(number, data[:99_000])
        raise OSError(28, "No space left on device")

    def refused(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    monkeypatch.setattr(Path, "replace", refused)
    with pytest.raises(OSError, match="No space left"):
        replace_file(file, bytes(100_000), b"old")
    assert file.read_bytes() == b"old"


def test_a_protected_file_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "a"
    file.write_bytes(b"old")
    file.chmod(0o444)
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # for root, too
    with pytest.raises(PermissionError):
        replace_file(file, b"new", b"old")
    assert file.read_bytes() == b"old"


def test_an_output_is_a_file_a_device_or_a_pipe_with_a_reader(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file, pipe, plug = Path("file"), Path("pipe"), Path("plug")
    for content in (b"longer", b"new"):
        with create_file(file) as stream:
            stream.write(content)
        assert file.read_bytes() == content
    with create_file(Path("/dev/null")) as stream:
        stream.write(b"x")
    a_pipe(pipe)
    with pytest.raises(UnreadableError, match="nothing reads this pipe"):
        create_file(pipe)
    with pytest.raises(UnreadableError, match="it is a pipe, not a file"):
        check_output(pipe, pipes=False)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    with create_file(pipe) as stream:
        assert os.get_blocking(stream.fileno())
        stream.write(b"through")
    assert os.read(reader, 99) == b"through"
    os.close(reader)
    a_socket(plug)
    for path, problem in ((plug, "a socket"), (Path("a\0b"), "null character")):
        with pytest.raises(UnreadableError, match=problem):
            create_file(path)
    with pytest.raises(IsADirectoryError):
        create_file(tmp_path)
