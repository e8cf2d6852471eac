"""`rtgen diff` on files, folders and git revisions; allowed breaks; forms of output; errors."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable
from functools import reduce
from pathlib import Path

import pytest
from json_schemas import valid

from rtgen.cli import run
from rtgen.tools.diff import revisions

OLD = "struct Pose { double x; };\n"
NEW = "struct Pose { double x; double y; };\n"
COMPONENT = '#include "pose.idl"\ncomponent Base { consumes Pose Where; };\n'


def git(*arguments: str) -> None:
    """Run git with an author set."""
    names = ["-c", "user.name=me", "-c", "user.email=me@example.com"]
    subprocess.run(["git", *names, *arguments], check=True, capture_output=True)


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project in a repository whose revision `main` has the old type."""
    monkeypatch.chdir(tmp_path)
    Path("robot/specs").mkdir(parents=True)
    Path("robot/rtgen.toml").write_text('[sources]\npaths = ["specs"]\n')
    Path("robot/specs/pose.idl").write_text(OLD)
    Path("robot/specs/base.idl").write_text(COMPONENT)
    git("init", "-q", "-b", "main")
    git("add", ".")
    git("commit", "-q", "-m", "old")
    monkeypatch.chdir(tmp_path / "robot")
    Path("specs/pose.idl").write_text(NEW)
    return tmp_path / "robot"


def changes(capfd: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    """Return the changes that were printed as JSON."""
    found = valid(capfd.readouterr().out, "diff.schema.json")
    listed: list[dict[str, object]] = found["changes"]
    return listed


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "arguments",
    [
        ["main"],
        ["--against", "main"],
        ["--against", "HEAD", "specs"],
        ["--against", "main", "specs/pose.idl"],
        ["main:robot/specs", "specs"],
        ["main:./specs/pose.idl", "specs/pose.idl"],
        ["main:robot", "."],
    ],
)
@pytest.mark.usefixtures("project")
def test_a_revision_is_compared_with_the_working_tree(
    arguments: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(["diff", "--json", *arguments]) == 1
    [change] = changes(capfd)
    assert change["code"] == "DIF0110"
    assert change["wires"] == ["CDR", "XCDR1", "XCDR2"]
    old, new = change["old"], change["new"]
    assert isinstance(old, dict)
    assert isinstance(new, dict)
    assert old["file"].endswith(":robot/specs/pose.idl")
    assert new["file"].endswith("specs/pose.idl")
    assert (old["line"], old["column"]) == (1, 8)
    assert (new["line"], new["column"]) == (1, 32)


@pytest.mark.usefixtures("project")
def test_users_are_named(capfd: pytest.CaptureFixture[str]) -> None:
    run(["diff", "main", "--json"])
    [change] = changes(capfd)
    users = change["users"]
    assert isinstance(users, list)
    assert [(u["kind"], u["name"]) for u in users] == [
        ("type", "Pose"),
        ("port", "Base.Where"),
    ]


@pytest.mark.usefixtures("project")
def test_nothing_changed(capfd: pytest.CaptureFixture[str]) -> None:
    Path("specs/pose.idl").write_text("// a comment\nstruct Pose {\n  double x;\n};\n")
    assert run(["diff", "main"]) == 0
    assert capfd.readouterr().err == "no change of meaning\n"


@pytest.mark.parametrize(
    ("use", "code"),
    [("wire", 1), ("source", 0), ("source,stored", 1), ("compatible", 0)],
)
@pytest.mark.usefixtures("project")
def test_the_exit_code_is_that_of_the_classes_asked_for(use: str, code: int) -> None:
    assert run(["diff", "main", "--use", use]) == code


ALLOW = """
[[diff.allow]]
code = "{code}"
name = "{name}"
path = "{path}"
reason = "nobody has built the old one"
"""


def allow(code: str = "DIF0110", name: str = "Pose.*", path: str = "*.idl") -> None:
    """Add an allowance to the project."""
    with Path("rtgen.toml").open("a") as stream:
        stream.write(ALLOW.format(code=code, name=name, path=path))


@pytest.mark.usefixtures("project")
def test_an_allowed_break_is_a_note_with_its_reason(
    capfd: pytest.CaptureFixture[str],
) -> None:
    allow()
    assert run(["diff", "main"]) == 0
    err = capfd.readouterr().err
    assert "note[DIF0110]" in err
    assert "allowed: nobody has built the old one" in err
    assert "1 allowed" in err


@pytest.mark.parametrize(
    "other",
    [{"code": "DIF0111"}, {"name": "Place.*"}, {"path": "other/*"}, {"code": "X"}],
)
@pytest.mark.usefixtures("project")
def test_an_unused_allowance_is_reported(
    other: dict[str, str], capfd: pytest.CaptureFixture[str]
) -> None:
    allow("DIF0113")
    allow(**other)
    assert run(["diff", "main"]) == 1
    err = capfd.readouterr().err
    assert "rtgen.toml:4:3: warning[DIF0004]" in err
    assert "rtgen.toml:10:3: warning[DIF0004]" in err
    assert "error[DIF0110]" in err


@pytest.mark.parametrize(
    "text",
    [
        '[diff]\nuse = ["wires"]\n',
        '[[diff.allow]]\ncode = "DIF0110"\n',
        "[diff]\nx = 1\n",
    ],
)
@pytest.mark.usefixtures("project")
def test_wrong_settings_are_errors(
    text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with Path("rtgen.toml").open("a") as stream:
        stream.write(text)
    assert run(["diff", "main"]) == 2
    assert "rtgen.toml:" in capfd.readouterr().err


def test_a_project_without_keys_gets_some(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in (("old", "[tecs]\n"), ("new", "[tecs]\ncorba = true\n")):
        Path(name).mkdir()
        Path(name, "rtgen.toml").write_text(f'[sources]\npaths = ["."]\n{text}')
        Path(name, "pose.idl").write_text(OLD)
    assert run(["diff", "old", "new", "--json"]) == 1
    [change] = changes(capfd)
    assert change["subject"] == "tecs.corba"
    old = change["old"]
    assert isinstance(old, dict)
    assert (old["file"], old["line"]) == ("old/rtgen.toml", 1)


@pytest.mark.usefixtures("project")
def test_settings_choose_the_classes() -> None:
    with Path("rtgen.toml").open("a") as stream:
        stream.write('[diff]\nuse = ["source"]\n')
    assert run(["diff", "main"]) == 0
    assert run(["diff", "main", "--use", "wire"]) == 1


@pytest.mark.usefixtures("project")
def test_forms_for_machines(capfd: pytest.CaptureFixture[str]) -> None:
    run(["diff", "main", "--diagnostics", "github"])
    assert capfd.readouterr().err.startswith("::error file=specs/pose.idl,line=1,")
    run(["diff", "main", "--diagnostics", "json"])
    [finding] = json.loads(capfd.readouterr().err)
    assert finding["related"][0]["file"] == "main:robot/specs/pose.idl"
    run(["diff", "main", "--diagnostics", "sarif"])
    [result] = json.loads(capfd.readouterr().err)["runs"][0]["results"]
    assert result["ruleId"] == "DIF0110"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nain"], "did you mean main?"),
        (["--against", "specs"], "not a file, folder or git revision"),
        (["--help:x"], "or git revision"),
        (["main:robot/none.idl"], "main has no robot/none.idl"),
        (["main", "none.idl"], "'none.idl' is not a file"),
        (["a", "b", "c"], "two versions"),
        (["--against", "main", "a", "b"], "one argument"),
        (["main", "--use", "wires"], "'wires' is none of"),
    ],
)
@pytest.mark.usefixtures("project")
def test_wrong_arguments(
    arguments: list[str], message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert (
        run(
            ["diff", "--", *arguments]
            if arguments[:1] == ["--help:x"]
            else ["diff", *arguments]
        )
        == 2
    )
    assert message in capfd.readouterr().err


@pytest.mark.usefixtures("project")
def test_errors_of_the_old_version_have_its_places(
    capfd: pytest.CaptureFixture[str],
) -> None:
    Path("specs/pose.idl").write_text("struct Pose { doubl x; };\n")
    git("add", ".")
    git("commit", "-q", "-m", "broken")
    Path("specs/pose.idl").write_text(NEW)
    assert run(["diff", "HEAD"]) == 2
    assert "HEAD:robot/specs/pose.idl:1:15: error[" in capfd.readouterr().err


@pytest.mark.usefixtures("project")
def test_a_revision_without_the_project(capfd: pytest.CaptureFixture[str]) -> None:
    Path("rtgen.toml").rename("other.txt")
    git("add", "-A")
    git("commit", "-q", "-m", "without")
    Path("other.txt").rename("rtgen.toml")
    assert run(["diff", "HEAD"]) == 2
    assert "HEAD has no robot/rtgen.toml" in capfd.readouterr().err


@pytest.mark.usefixtures("project")
def test_too_large_a_revision(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(revisions, "MAX_FILES", 2)
    assert run(["diff", "main"]) == 2
    assert "error[DIF0003]" in capfd.readouterr().err


@pytest.mark.parametrize("branch", ["main", "master", "trunk", "develop"])
@pytest.mark.usefixtures("project")
def test_the_old_version_is_the_main_branch(
    branch: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """`trunk` is that of the remote, `develop` that of rtgen.toml."""
    git("commit", "-q", "-a", "-m", "new")
    git("branch", "-q", "-m", "main", "mine")
    assert run(["diff"]) == 2
    assert "name OLD, or --against REVISION" in capfd.readouterr().err
    if branch == "trunk":
        git("update-ref", "refs/remotes/origin/trunk", "HEAD~1")
        git("symbolic-ref", "refs/remotes/origin/HEAD", "refs/remotes/origin/trunk")
        git("branch", "main")  # of someone else's making
    else:
        git("branch", branch, "HEAD~1")
    if branch == "develop":
        with Path("rtgen.toml").open("a") as stream:
            stream.write('[diff]\nagainst = "develop"\n')
    assert run(["diff", "--json"]) == 1
    assert "DIF0110" in [change["code"] for change in changes(capfd)]


@pytest.mark.usefixtures("project")
def test_an_unknown_revision_is_reported_at_its_place(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with Path("rtgen.toml").open("a") as stream:
        stream.write('[diff]\nagainst = "nain"\n')
    assert run(["diff"]) == 2
    assert "rtgen.toml:4:1: error[DIF0001]" in capfd.readouterr().err


@pytest.mark.usefixtures("project")
def test_without_git(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", "")
    assert run(["diff", "main"]) == 3
    assert "git is not installed" in capfd.readouterr().err


def test_outside_of_a_repository(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert run(["diff", "main"]) == 2
    assert "in no git repository" in capfd.readouterr().err


def test_folders_without_a_project(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in (("old", OLD), ("new", NEW)):
        Path(name).mkdir()
        Path(name, "pose.idl").write_text(text)
    assert run(["diff", "old", "new", "--json"]) == 1
    [change] = changes(capfd)
    assert change["old"] is not None


def stored(kind: str, content: bytes) -> str:
    """Store an object in the repository as it is, and return its name."""
    command = ["git", "hash-object", "-t", kind, "--literally", "-w", "--stdin"]
    done = subprocess.run(command, input=content, capture_output=True, check=True)
    return done.stdout.decode().strip()


def tree(*entries: tuple[str, bytes, str]) -> str:
    """Store a tree: mode, name and object of each entry."""
    parts = (
        mode.encode() + b" " + name + b"\0" + bytes.fromhex(object_)
        for mode, name, object_ in entries
    )
    return stored("tree", b"".join(parts))


def committed(tree_: str) -> str:
    who = "me <me@example.com> 0 +0000"
    text = f"tree {tree_}\nauthor {who}\ncommitter {who}\n\nstrange\n"
    return stored("commit", text.encode())


MISSING = "12345678" * 5
STRANGE: dict[str, Callable[[str], str]] = {
    "long name": lambda blob: tree(("100644", b"n" * 300 + b".idl", blob)),
    "dot": lambda blob: tree(("100644", b".", blob)),
    "two dots": lambda blob: tree(("40000", b"..", tree(("100644", b"a.idl", blob)))),
    "folder called dot": lambda blob: tree(
        ("40000", b".", tree(("100644", b"a.idl", blob)))
    ),
    "file and folder": lambda blob: tree(
        ("100644", b"a", blob), ("40000", b"a", tree(("100644", b"b", blob)))
    ),
    "two of one name": lambda blob: tree(
        ("100644", b"a.idl", blob), ("100644", b"a.idl", stored("blob", b"other"))
    ),
    "missing content": lambda blob: tree(("100644", b"a.idl", MISSING)),
    "missing folder": lambda blob: tree(("40000", b"a", MISSING)),
    "folder as a file": lambda blob: tree(("100644", b"a.idl", tree())),
    "deep folders": lambda blob: reduce(
        lambda inner, _: tree(("40000", b"n" * 200, inner)),
        range(100),
        tree(("100644", b"a.idl", blob)),
    ),
    "endless folders": lambda blob: reduce(
        lambda inner, _: tree(*(("40000", b"%d" % n, inner) for n in range(10))),
        range(12),
        tree(("100644", b"a.idl", blob)),
    ),
    "slash in a name": lambda blob: tree(("100644", b"/a.idl", blob)),
}


@pytest.mark.sampled(4)
@pytest.mark.usefixtures("project")
@pytest.mark.parametrize("kind", STRANGE)
def test_strange_trees_are_refused_in_a_line(
    kind: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(revisions, "_MAX_LISTING", 1 << 20)
    commit = committed(STRANGE[kind](stored("blob", OLD.encode())))
    assert run(["diff", commit]) == 2
    error, *rest = capfd.readouterr().err.splitlines()
    assert re.fullmatch(r"error\[DIF000[123]\]: .+", error), error
    assert len(error) < 500
    assert len(rest) <= 2


@pytest.mark.usefixtures("project")
def test_damaged_content_is_reported(capfd: pytest.CaptureFixture[str]) -> None:
    blob = stored("blob", OLD.encode() * 1000)
    commit = committed(tree(("100644", b"pose.idl", blob)))
    file = Path("../.git/objects", blob[:2], blob[2:])
    file.chmod(0o600)
    file.write_bytes(file.read_bytes()[:40])
    assert run(["diff", commit]) == 2
    assert "error[DIF0002]" in capfd.readouterr().err


@pytest.mark.usefixtures("project")
def test_names_that_are_not_text_are_read(capfd: pytest.CaptureFixture[str]) -> None:
    blob = stored("blob", OLD.encode())
    settings = stored("blob", b'[sources]\npaths = ["specs"]\n')
    specs = tree(("100644", b"a \n\xff.idl", blob), ("100644", b"pose.idl", blob))
    robot = tree(("100644", b"rtgen.toml", settings), ("40000", b"specs", specs))
    commit = committed(tree(("40000", b"robot", robot)))
    assert run(["diff", commit]) in (1, 2)
    assert "internal error" not in capfd.readouterr().err
