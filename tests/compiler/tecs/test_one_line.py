"""One line in a CDL file: the lines generated for it, and the files removed with it.

The paper (Table 3) counts lines without comments and blank lines for one function without
arguments; so does this test.
"""

from __future__ import annotations

import io
import re
import tokenize
from pathlib import Path

import pytest
from boards import emit, joined, texts

from rtgen.cli import run

DOCS = Path(__file__).parents[3] / "docs" / "tecs.md"
SIGNATURE = "signature sServer { ER func( void ); };\n"
LINE = '  [through(RTCPlugin,"")]\n'
PROJECT = '[sources]\npaths = ["cdl"]\n'

PARTS = {
    "marshaller code, with the client's base": (
        "robots/tecs/board/server_marshaller.py",
        "robots/tecs/board/server_codec.py",
    ),
    "communication code": (),
    "IDL": ("robots/tecs/board/Server.idl",),
    "server code": ("robots/tecs/board/server_server.py",),
    "client skeleton": ("nodes/server_client.py",),
    "profile, settings, tecsgen's plug-in": (
        "robots/tecs/board/RTC.xml",
        "robots/tecs/board/OpaqueRpcCommunication0.conf",
        "robots/tecs/board/RTCPlugin.rb",
    ),
}
"""The parts that the paper's authors wrote by hand, then those that they did not have.

The communication code is in the runtime.
"""


def lines(path: str, text: str) -> int:
    """Return the number of lines of code: no comments, no docstrings, no blank lines."""
    if path.endswith(".py"):
        return _python_lines(text)
    text = re.sub(r"/\*.*?\*/|<!--.*?-->", "", text, flags=re.DOTALL)
    marks = ("//", "#", "rem ") if not path.endswith(".idl") else ("//",)
    kept = (line.strip() for line in text.split("\n"))
    return sum(bool(line) and not line.startswith(marks) for line in kept)


def _python_lines(text: str) -> int:
    layout = (
        tokenize.COMMENT,
        tokenize.NL,
        tokenize.NEWLINE,
        tokenize.INDENT,
        tokenize.DEDENT,
        tokenize.ENDMARKER,
    )
    found: set[int] = set()
    before = tokenize.NEWLINE
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        is_docstring = token.type == tokenize.STRING and before in layout
        if token.type not in layout and not is_docstring:
            found.update(range(token.start[0], token.end[0] + 1))
        if token.type not in (tokenize.COMMENT, tokenize.NL):
            before = token.type
    return len(found)


def counted(folder: Path) -> dict[str, int]:
    emission, _ = emit(folder, {"board.cdl": joined(SIGNATURE, "sServer")})
    made = texts(emission.artifacts)
    return {
        part: sum(lines(path, made[path]) for path in paths)
        for part, paths in PARTS.items()
    }


def test_the_lines_that_one_line_makes(tmp_path: Path) -> None:
    """`docs/tecs.md` compares these figures with those of the paper."""
    counts = counted(tmp_path)
    assert joined(SIGNATURE, "sServer").count("RTCPlugin") == 1
    assert [part for part in counts if not counts[part]] == ["communication code"]
    if not DOCS.exists():
        pytest.skip("docs/tecs.md is missing")
    documented = dict(
        re.findall(r"^\| ([^|]+?) \| (\d+) \|$", DOCS.read_text(), re.MULTILINE)
    )
    wanted = {part: str(count) for part, count in counts.items()}
    wanted["together"] = str(sum(counts.values()))
    assert {part: documented.get(part) for part in wanted} == wanted


def generated(folder: Path) -> set[str]:
    below = folder / "generated"
    return {p.relative_to(below).as_posix() for p in below.rglob("*") if p.is_file()}


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "cdl").mkdir()
    (tmp_path / "rtgen.toml").write_text(PROJECT)
    (tmp_path / "cdl" / "board.cdl").write_text(joined(SIGNATURE, "sServer"))
    assert run(["generate"]) == 0
    return tmp_path


def test_a_client_is_the_users(project: Path) -> None:
    client = project / "src" / "server_client.py"
    client.write_text("# mine\n")
    assert run(["generate"]) == 0
    assert client.read_text() == "# mine\n"
    assert run(["check"]) == 0
    assert run(["check", "--no-cache"]) == 0


def test_without_the_line_all_goes_but_what_is_the_users(project: Path) -> None:
    board = project / "cdl" / "board.cdl"
    text = board.read_text()
    assert text.count(LINE) == 1
    client = project / "src" / "server_client.py"
    client.write_text("# mine\n")
    notes = project / "generated" / "robots" / "tecs" / "board" / "notes.txt"
    notes.write_text("mine, too\n")
    board.write_text(text.replace(LINE, ""))
    assert run(["generate"]) == 0
    assert generated(project) == {".rtgen.json", "robots/tecs/board/notes.txt"}
    assert client.read_text() == "# mine\n"
    assert run(["check"]) == 1  # notes.txt is a stray, as before
    notes.unlink()
    assert run(["check"]) == 0
    board.write_text(text)
    assert run(["generate"]) == 0
    assert client.read_text() == "# mine\n"
    assert run(["check"]) == 0


def test_a_client_that_is_deleted_is_made_again(project: Path) -> None:
    client = project / "src" / "server_client.py"
    client.unlink()
    assert run(["check"]) == 0
    assert run(["generate"]) == 0
    assert client.exists()
