"""Stored answers of `check` and `lint`: what changes is seen, what does not is not read again."""

from __future__ import annotations

import gc
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import heating_project
import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics.explain import MODULES
from rtgen.compiler.kit import own_files
from rtgen.facts import looks
from rtgen.tools.kit import answers, pages

TRIES = 10
ROOT = Path(__file__).parents[3]
CHECK = ("check",)
LINT = ("lint", "--diagnostics", "json")


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return the folder of a project with generated files, in which the tests work."""
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    folder = tmp_path / "project"
    for name, text in heating_project.FILES.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    with (folder / "rtgen.toml").open("a") as stream:
        stream.write('[templates]\npath = "templates"\n')
    settings = (folder / "rtgen.toml").read_text()
    settings = settings.replace("[output]", 'include = ["first", "second"]\n\n[output]')
    (folder / "rtgen.toml").write_text(settings)
    (folder / "first").mkdir()
    (folder / "second").mkdir()
    (folder / "second/more.idl").write_text("struct More { long value; };\n")
    with (folder / "idl/heating.idl").open("a") as stream:
        stream.write('#include "more.idl"\n')
    (folder / "templates/types").mkdir(parents=True)
    shutil.copy(ROOT / "src/rtgen/templates/header.txt.j2", folder / "templates")
    monkeypatch.chdir(folder)
    assert run(["generate", "-q"]) == 0
    yield folder
    gc.enable()


def printed(
    command: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> tuple[int, str, str]:
    """Run a command until its answer is stored; return exit code and output."""
    monkeypatch.setattr(sys, "argv", ["rtgen", *command])
    for _ in range(TRIES):  # files that were changed just before are read once more
        capfd.readouterr()
        code = run(command, ends=True)
        output = capfd.readouterr()
        if answers.repeat(command) is not None:
            assert capfd.readouterr() == output
            return code, *output
    raise AssertionError("no answer is stored")


def imported(*arguments: str) -> set[str]:
    """Return the modules that Python imports with these arguments."""
    command = [sys.executable, "-X", "importtime", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}


def edited(name: str, old: str, new: str) -> Callable[[], None]:
    """Return an edit that leaves the size and the time of modification of a file as they are."""

    def edit() -> None:
        file = Path(name)
        before = file.stat()
        text = file.read_text()
        assert old in text
        assert len(old) == len(new)
        file.write_text(text.replace(old, new, 1))
        os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))

    return edit


def written(name: str, text: str = "") -> Callable[[], None]:
    def write() -> None:
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(text)

    return write


def remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()


def replaced_by_link(name: str) -> Callable[[], None]:
    def link() -> None:
        file = Path(name)
        other = file.with_name("other.txt")
        other.write_text(file.read_text() + "\n")
        file.unlink()
        file.symlink_to(other.name)

    return link


BOTH = {
    "a definition of equal size and time": edited("idl/heating.idl", "watt", "volt"),
    "a new definition": written("idl/new.idl", "struct New { long value; };\n"),
    "a new folder with one": written("idl/in/new.idl", "struct New { long a; };\n"),
    "a definition renamed": lambda: Path("idl/heating.idl").rename("idl/warm.idl"),
    "a definition removed": lambda: Path("idl/heating.idl").unlink(),
    "a link instead of a definition": replaced_by_link("idl/heating.idl"),
    "an included file": edited("second/more.idl", "long", "char"),
    "an included file in a folder before": written("first/more.idl", "struct More {"),
    "an included file removed": lambda: Path("second/more.idl").unlink(),
    "a folder of rtgen.toml removed": lambda: Path("first").rmdir(),
    "rtgen.toml": edited("rtgen.toml", "warmth", "mouths"),
    "rtgen.toml removed": lambda: Path("rtgen.toml").unlink(),
    "a template": edited("templates/header.txt.j2", "Generated", "Gegenerat"),
    "a new template": written("templates/types/unknown.j2"),
    "a system": edited("systems/warm/system.xml", "Heater0", "Heater9"),
    "a timeline": edited("systems/warm/timeline.toml", "at", "et"),
    "a behaviour": edited("src/heating/heater.py", "import", "export"),
    "a new behaviour": written("src/heating/second.py", "import"),
    "a rename that was interrupted": written(".rtgen-rename.json", "{}"),
}
"""Changes that `check` and `lint` depend on."""
OF_CHECK = {
    "a generated file": lambda: next(Path("generated").rglob("*.py")).write_text(""),
    "a generated file removed": lambda: next(Path("generated").rglob("*.py")).unlink(),
    "a file among those generated": written("generated/stray.txt"),
    "a folder among those generated": written("generated/warmth/some/stray.txt"),
    "the manifest": lambda: Path("generated/.rtgen.json").write_text("{}"),
    "a link among those generated": lambda: Path("generated/way").symlink_to("."),
    "the output folder removed": lambda: shutil.rmtree("generated"),
}


def test_what_changes_is_seen(
    project: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    outputs = {each: printed(each, monkeypatch, capfd) for each in (CHECK, LINT)}
    before = shutil.copytree(project, tmp_path / "before", symlinks=True)
    for name, change in {**BOTH, **OF_CHECK}.items():
        change()
        assert answers.repeat(CHECK) is None, name
        if name in BOTH:
            assert answers.repeat(LINT) is None, name
        assert capfd.readouterr() == ("", ""), name
        for each in project.iterdir():
            remove(each)
        shutil.copytree(before, project, symlinks=True, dirs_exist_ok=True)
        for command, output in outputs.items():
            code = answers.repeat(command)
            assert (code, *capfd.readouterr()) == output, f"{name}, and undone"


def test_how_it_is_called_is_seen(
    project: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    printed(CHECK, monkeypatch, capfd)
    assert answers.repeat([*CHECK, "-q"]) is None
    assert answers.repeat([*CHECK, "--no-cache"]) is None
    for name in (*answers.VARIABLES, "RTGEN_NEW"):
        with monkeypatch.context() as context:
            context.setenv(name, "another")
            assert answers.repeat(CHECK) is None, name
    with monkeypatch.context() as context:
        context.chdir("idl")
        assert answers.repeat(CHECK) is None
    with monkeypatch.context() as context:
        context.setattr(sys, "version", "another")
        assert answers.repeat(CHECK) is None
    assert answers.repeat(CHECK) == 0


def test_another_rtgen_is_seen(
    project: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    module = tmp_path / "compiler" / "module.py"
    module.parent.mkdir()
    module.write_text("1")
    monkeypatch.setattr(answers, "compiler_folders", lambda: [str(module.parent)])
    printed(CHECK, monkeypatch, capfd)
    before = module.stat()
    module.write_text("2")
    os.utime(module, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert answers.repeat(CHECK) is None
    printed(CHECK, monkeypatch, capfd)
    module.with_name("second.py").write_text("")
    assert answers.repeat(CHECK) is None


def test_other_packages_are_seen(
    project: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    site = tmp_path / "site"
    library = site / "lark-1.dist-info"
    library.mkdir(parents=True)
    monkeypatch.syspath_prepend(site)
    printed(CHECK, monkeypatch, capfd)
    library.rename(site / "lark-2.dist-info")
    assert answers.repeat(CHECK) is None
    printed(CHECK, monkeypatch, capfd)
    announced = site / "lark-2.dist-info" / "entry_points.txt"
    announced.write_text("[rtgen.lint]\nx = missing:LINT\n")
    assert answers.repeat(CHECK) is None
    announced.parent.rename(site / "brings-1.dist-info")
    for _ in range(2):
        assert run(CHECK, ends=True) == 3
        assert answers.repeat(CHECK) is None, "a plug-in may look at anything"


def test_packages_that_cannot_be_read_announce_nothing(
    project: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    before, site = os.listdir, tmp_path / "site"
    site.mkdir()

    def listdir(path: Path) -> list[str]:
        if path == site:
            raise PermissionError(13, "Permission denied", str(path))
        return before(path)

    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(os, "listdir", listdir)
    assert printed(CHECK, monkeypatch, capfd)[0] == 0


def test_an_answer_is_stored_only_if_the_files_are_those_that_were_read(
    project: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    printed(CHECK, monkeypatch, capfd)
    shutil.rmtree(Path(own_files.user_folder()))
    digest = looks.digest

    def changed(name: str) -> str:
        result = digest(name)
        if name.endswith("controller.py"):
            Path(name[1:]).touch()
        return result

    monkeypatch.setattr(looks, "digest", changed)
    assert run(CHECK, ends=True) == 0
    assert answers.repeat(CHECK) is None


@pytest.mark.parametrize("time", [1_000_000_000_000_000_000, 1_000_000_000_123_456_789])
def test_the_time_of_a_change(time: int) -> None:
    """A file that may have changed again within the precision of its time is read again."""
    status = f"5 {time} {time} 7"
    precision = 20_000_000 if time % 1_000_000_000 else 2_000_000_000
    assert not looks.is_settled(status, time + precision)
    assert looks.is_settled(status, time + precision + 1)
    assert not looks.is_settled(f"5 {time - 10**10} {time} 7", time)


def test_a_time_alone_is_stored(
    project: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Files of a new clone are read once."""
    printed(CHECK, monkeypatch, capfd)
    for file in project.rglob("*"):
        os.utime(file, ns=(1, 1))
    monkeypatch.setattr(looks, "is_settled", lambda *_: True)
    read: list[str] = []
    digest = looks.digest

    def noting(name: str) -> str:
        read.append(name)
        return digest(name)

    monkeypatch.setattr(looks, "digest", noting)
    assert answers.repeat(CHECK) == 0
    assert read
    read.clear()
    assert answers.repeat(CHECK) == 0
    assert not read


@pytest.mark.sampled(2)
@pytest.mark.parametrize("form", ["text", "json", "sarif", "github"])
def test_lint_prints_the_same_with_and_without_cache(
    project: Path,
    form: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    command = ("lint", "--diagnostics", form, "--color", "always")
    code, out, err = printed(command, monkeypatch, capfd)
    assert err
    assert run([*command, "--no-cache"]) == code
    assert capfd.readouterr() == (out, err)


def test_a_stored_answer_imports_little(project: Path) -> None:
    """What prints it takes a few milliseconds; `typing` or `re` alone would double them."""
    for _ in range(TRIES):
        modules = imported("-m", "rtgen", *CHECK)
        if "rtgen.cli" not in modules:
            break
    assert {each for each in modules if each.startswith("rtgen.")} <= {
        "rtgen.compiler",
        "rtgen.compiler.kit",
        "rtgen.compiler.kit.own_files",
        "rtgen.facts",
        "rtgen.facts.looks",
        "rtgen.facts.version",
        "rtgen.tools",
        "rtgen.tools.kit",
        "rtgen.tools.kit.answers",
        "rtgen.tools.kit.terminals",
    }
    of_python = imported("-c", "import runpy")
    slow = {"click", "dataclasses", "enum", "json", "re", "typing"}
    assert not (modules - of_python) & slow


def test_a_page_needs_no_library(project: Path) -> None:
    modules = imported("-m", "rtgen", "explain", "IDL0200")
    assert "rtgen.tools.kit.pages" in modules
    assert not modules & {"click", "msgspec", "rich", "rtgen.cli"}


def test_rules_are_read_without_what_reports_them() -> None:
    modules = imported("-c", f"import {', '.join(MODULES)}")
    assert modules >= MODULES.keys()
    assert not modules & {"dataclasses", "msgspec", "rtgen.compiler.model"}


@pytest.mark.parametrize("code", ["idl020", ""])
def test_what_is_said_of_several_codes_is_stored(
    project: Path,
    code: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    printed(("explain", *filter(None, [code])), monkeypatch, capfd)


def test_a_page_is_as_quick_without_a_stored_one(project: Path) -> None:
    command = ["explain", "IDL0200"]
    assert pages.explained(command) == 0
    assert answers.repeat(command) is None


def test_a_page_for_a_terminal_is_not_stored(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ["explain", "IDL0200"]
    monkeypatch.setattr(sys, "argv", ["rtgen", *command])
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    for _ in range(3):
        assert run(command, ends=True) == 0
        assert answers.repeat(command) is None


def test_a_fix_is_made_each_time(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = ["lint", "--fix"]
    monkeypatch.setattr(sys, "argv", ["rtgen", *command])
    for _ in range(3):
        run(command, ends=True)
        assert answers.repeat(command) is None


@pytest.mark.parametrize("damage", ["empty", "cut", "changed", "folder", "pipe"])
def test_a_damaged_answer_is_not_given(
    project: Path,
    damage: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    printed(CHECK, monkeypatch, capfd)
    [file] = Path(own_files.user_folder()).rglob("*.answer")
    data = file.read_bytes()
    if damage in ("folder", "pipe"):
        file.unlink()
        file.mkdir() if damage == "folder" else os.mkfifo(file, mode=0o600)
    else:
        changed = data.replace(b"heater", b"hooter", 1)
        file.write_bytes({"empty": b"", "cut": data[:-9], "changed": changed}[damage])
    assert answers.repeat(CHECK) is None
    if damage not in ("folder", "pipe"):
        file.write_bytes(data)
        assert answers.repeat(CHECK) == 0
        file.chmod(0o620)
        assert answers.repeat(CHECK) is None, "another user may have written it"


LOOKED_AT = """
import os, sys
from contextlib import contextmanager
asked, noted_looks = set(), {}
active = False
def note(event, path):
    if active and isinstance(path, (str, bytes, os.PathLike)):
        asked.add((event, os.path.normpath(os.path.join(os.getcwd(), os.fsdecode(path)))))
sys.addaudithook(
    lambda e, a: note(e, a[0]) if e in ("open", "os.listdir", "os.scandir") else None
)
def resolves(frame):
    return frame and (frame.f_code.co_name in ("realpath", "resolve") or resolves(frame.f_back))
def noting(function):
    def call(path, *args, **options):
        if not resolves(sys._getframe(1)):
            note("stat", path)
        return function(path, *args, **options)
    return call
os.stat, os.lstat = noting(os.stat), noting(os.lstat)
import rtgen.cli
from rtgen.facts import looks
original = looks.noted
@contextmanager
def noted():
    global active
    with original() as seen:
        active = True
        yield seen
        active = False
    noted_looks.update(seen)
looks.noted = noted
sys.argv[0] = "rtgen"
rtgen.cli.run(sys.argv[1:], ends=True)
assert noted_looks
paths = {os.path.normpath(name[1:]) for name in noted_looks}
folders = {os.path.normpath(name[1:]) for name in noted_looks if name[0] == looks.NAMES}
for event, path in sorted(asked):
    is_listed = event == "stat" and os.path.dirname(path) in folders
    if path.startswith(os.getcwd()) and path not in paths and not is_listed:
        print(event, path)
"""
"""Prints what a command asks of the disk below the working folder without noting a look."""


@pytest.mark.sampled(2)
@pytest.mark.parametrize("command", [CHECK, LINT])
@pytest.mark.parametrize("fault", ["", "idl/heating.idl", "rtgen.toml"])
def test_all_that_a_command_looks_at_is_noted(
    project: Path, command: tuple[str, ...], fault: str
) -> None:
    if fault:
        with Path(fault).open("a") as stream:
            stream.write("error\n")
    program = [sys.executable, "-c", LOOKED_AT, *command]
    done = subprocess.run(program, capture_output=True, text=True, check=True)
    assert done.stdout == ""


def test_each_variable_of_the_environment_is_known() -> None:
    """Variables that the compiler and its tools read decide answers, too."""
    pattern = re.compile(r"""environ(?:\.get\(|\[)"(\w+)\"""")
    names: set[str] = set()
    for folder in ("compiler", "openrtm", "ros2", "tools/compiling", "tools/kit"):
        for file in (ROOT / "src/rtgen" / folder).rglob("*.py"):
            names.update(pattern.findall(file.read_text()))
    for file in (ROOT / "src/rtgen/cli").glob("*.py"):
        names.update(pattern.findall(file.read_text()))
    places = {"RTGEN_CACHE_DIR", "XDG_CACHE_HOME"}
    unknown = {n for n in names - places if not n.startswith("RTGEN_")}
    assert names
    assert unknown <= {*answers.VARIABLES}
