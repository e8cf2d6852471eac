"""Executes the code blocks of a page of the documentation, and compares their output.

The info string of a fenced block is its kind:

- `console`: commands after `$ `, each with its output, messages first. A line `...` stands for any
  lines, `...` within a line for any text. Without output, the exit code must be 0. `cd FOLDER`
  holds for the commands and files after it.
- `python`, `toml`, `json`, `xml`: parsed; the imports of Python are executed.
- `idl`, `cdl`, `ini`, `text` and the like: shown only.

Comments are directives, and are not rendered:

- `<!-- page: in a new folder -->`, `<!-- page: in the repository -->`: the working folder of the
  following blocks; the repository is a copy.
- `<!-- page: in a clean clone -->`: a copy of what git has, where only the programs of the clone's
  own environment are run; without `Runner.clone` the blocks are skipped.
- `<!-- page: file NAME -->`: the next block is written to that file.
- `<!-- page: part of NAME -->`: the lines of the next block follow each other in that file.
- `<!-- page: $ COMMAND -->`: a command that the page does not show; `$REPOSITORY` is the folder of
  this repository.
- `<!-- page: output varies -->`: for each line of output in the next block, a line with the same
  words is printed; numbers may differ, and there may be more lines.
- `<!-- page: not run: REASON -->`: the next block needs something that tests do not have.
- `<!-- page: needs PROGRAM -->`: the next block is run where this program is.
"""

from __future__ import annotations

import ast
import difflib
import io
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from importlib import invalidate_caches
from pathlib import Path
from unittest.mock import patch

from free_ports import free_port
from lxml import etree
from markdown_it import MarkdownIt

from rtgen.cli import run as rtgen

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]

RUN_ELSEWHERE = frozenset({"gallery"})
"""The systems of the gallery, which are run by the tests of the reference build."""

SHOWN_ONLY = frozenset(
    {
        "cdl",
        "dockerfile",
        "idl",
        "ini",
        "jsonl",
        "python2",
        "text",
        "typescript",
        "yaml",
    }
)
_COMMENT = re.compile(r"<!-- page: (.*?) -->", re.DOTALL)
_VARYING = re.compile(
    r"^(wall \[s\]|ratio|実際の時間 \[s\]|比)( +)[\d.]+$", re.MULTILINE
)
_REPOSITORY = (
    *("specs", "generated", "reference/refnav", "benchmarks"),
    *("rtgen.toml", "Makefile", "examples"),
)
_RUNS: dict[str, tuple[int, str]] = {}
"""Simulated runs of systems of the repository, whose output is reproducible."""
_SLOWNESS = 2.5
"""How much longer a command is run for a time than its page says: a machine may be busy."""
_COMMAND_TIMEOUT = 300.0
"""Maximum duration of a command [s]."""

_HUB = "29536"
_PORTS = (_HUB, "8931", "8940")
"""Ports in the pages, which are replaced by free ones. The first is the default of the hub."""


class PageError(AssertionError):
    """A page differs from the behaviour of the programs."""


@dataclass(frozen=True)
class Block:
    """A fenced block: its info string, its text, its line in the page."""

    language: str
    text: str
    line: int


@dataclass(frozen=True)
class Directive:
    """The content of a comment `<!-- page: ... -->`."""

    text: str
    line: int


@dataclass(frozen=True)
class Command:
    """A command of a `console` block with its expected output."""

    text: str
    output: str
    line: int

    @property
    def in_background(self) -> bool:
        """Whether the page goes on while the command runs."""
        return self.text.endswith("&")


def parts(page: Path) -> Iterator[Block | Directive]:
    """Yield the blocks and directives of a page, in order."""
    for token in MarkdownIt("commonmark").parse(page.read_text(encoding="utf-8")):
        line = (token.map or [0])[0] + 1
        if token.type == "fence":
            yield Block(token.info.strip(), token.content, line)
        elif token.type == "html_block":
            for match in _COMMENT.finditer(token.content):
                yield Directive(match[1], line)


def commands(block: Block) -> list[Command]:
    """Return the commands of a `console` block; a backslash at the end of a line joins lines."""
    found: list[Command] = []
    lines = block.text.splitlines()
    number = 0
    while number < len(lines):
        first = number
        if not lines[number].startswith("$ "):
            raise PageError(
                f"line {block.line + number + 1}: a command begins with '$ '"
            )
        text = lines[number][2:]
        while text.endswith("\\"):
            number += 1
            text = f"{text[:-1].rstrip()} {lines[number].strip()}"
        number += 1
        output: list[str] = []
        while number < len(lines) and not lines[number].startswith("$ "):
            output.append(lines[number])
            number += 1
        text = re.sub(r"\s+#.*$", "", text).strip()
        found.append(Command(text, "\n".join(output), block.line + first + 1))
    return found


def matches(expected: str, printed: str) -> bool:
    """Return whether a text is as expected; `...` stands for any text."""
    pattern = re.escape(expected.strip("\n")).replace(r"\.\.\.", ".*")
    return re.fullmatch(pattern, printed.strip("\n"), re.DOTALL) is not None


@dataclass
class Runner:
    """Executes the blocks of one page below `folder`, and in a clean clone if there is one."""

    folder: Path
    clone: Path | None = None
    locale: str | None = None
    _place: Path | None = None
    _places: int = 0
    _file: str | None = None
    _part_of: str | None = None
    _skipped: str | None = None
    _elsewhere: bool = False
    _varies: bool = False
    _set: dict[str, str] = field(default_factory=dict)
    _background: list[subprocess.Popen[str]] = field(default_factory=list)
    _ports: dict[str, str] = field(default_factory=dict)

    def run(self, page: Path) -> None:
        """Execute all blocks of the page. Raises PageError at the first difference."""
        try:
            for part in parts(page):
                try:
                    self._carry_out(part)
                except PageError as error:
                    raise PageError(f"{page.name}:{part.line}: {error}") from None
        finally:
            self.close()

    def close(self) -> None:
        """End all running commands."""
        for process in self._background:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGTERM)
            process.communicate(timeout=_COMMAND_TIMEOUT)
        self._background.clear()

    def _carry_out(self, part: Block | Directive) -> None:
        if isinstance(part, Directive):
            self._obey(part.text)
            return
        skipped, self._skipped = self._skipped, None
        name, self._file = self._file, None
        whole, self._part_of = self._part_of, None
        varies, self._varies = self._varies, False
        if skipped is not None or self._elsewhere:
            return
        if whole is not None:
            _check_part(part.text, (self._here() / whole).read_text(encoding="utf-8"))
        if name is not None:
            path = self._here() / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(self._with_ports(part.text), encoding="utf-8")
        match part.language:
            case "console":
                for command in commands(part):
                    self._command(command, varies=varies)
            case language if language in _CHECKS:
                try:
                    _CHECKS[language](part.text)
                except (SyntaxError, ImportError, ValueError) as error:
                    raise PageError(f"{type(error).__name__}: {error}") from error
            case language if language not in SHOWN_ONLY:
                raise PageError(f"a block of unknown language {language!r}")

    def _obey(self, text: str) -> None:
        kind, _, rest = text.partition(" ")
        self._elsewhere = self._elsewhere and not text.startswith("in ")
        if text == "in a new folder":
            self._new_place()
        elif text == "in a clean clone":
            self._elsewhere = self.clone is None
            self._place = self.clone
        elif text == "in the repository":
            place = self._new_place()
            for name in _REPOSITORY:
                source, target = ROOT / name, place / name
                target.parent.mkdir(parents=True, exist_ok=True)
                if source.is_dir():
                    ignored = shutil.ignore_patterns("__pycache__")
                    shutil.copytree(source, target, ignore=ignored)
                else:
                    shutil.copy(source, target)
        elif kind == "file":
            self._file = rest
        elif text.startswith("part of "):
            self._part_of = text.removeprefix("part of ")
        elif kind == "$":
            self._command(Command(rest, "", 0))
        elif text == "output varies":
            self._varies = True
        elif text.startswith("not run: ") or (
            kind == "needs" and shutil.which(rest) is None
        ):
            self._skipped = text
        elif kind == "needs":
            pass
        else:
            raise PageError(f"unknown directive {text!r}")

    def _new_place(self) -> Path:
        self.close()
        self._places += 1
        self._place = self.folder / str(self._places)
        self._place.mkdir()
        return self._place

    def _here(self) -> Path:
        if self._place is None:
            raise PageError("no directive says where this is run")
        return self._place

    def _with_ports(self, text: str) -> str:
        for port in _PORTS:
            if port in text:
                text = text.replace(port, self._port(port))
        return text

    def _port(self, shown: str) -> str:
        if shown not in self._ports:
            self._ports[shown] = str(free_port())
        return self._ports[shown]

    def _command(self, command: Command, *, varies: bool = False) -> None:
        here = self._here()
        text = self._with_ports(command.text)
        if text.startswith("export "):
            self._set |= dict(word.split("=", 1) for word in shlex.split(text)[1:])
            return
        if re.fullmatch(r"cd [\w./-]+", text):
            self._place = here / text.removeprefix("cd ")
            return
        expected = _VARYING.sub(r"\1\2?", self._with_ports(command.output))
        if text.startswith("rtgen can hub"):
            text = text.replace("hub", f"hub --port {self._port(_HUB)}", 1)
        if command.in_background:
            self._start(text.removesuffix("&"), expected, here)
            return
        words = shlex.split(text)
        if varies and "--for" in words:
            place = words.index("--for") + 1
            words[place] = str(_SLOWNESS * float(words[place]))
        if (
            words[0] == "rtgen"
            and self.clone is None
            and not set("|<>$;*&") & set(text)
        ):
            known = _RUNS.get(text)
            code, printed = known or self._in_process(words[1:], here)
            if text.startswith("rtgen run specs/") and "--clock real" not in text:
                _RUNS[text] = code, printed
        else:
            code, printed = self._in_shell(text, here)
        printed = _VARYING.sub(r"\1\2?", printed)
        if not command.output:
            if code != 0:
                raise PageError(f"$ {text}\nends with exit code {code}:\n{printed}")
        elif varies:
            shapes = {_shape(line) for line in printed.splitlines()}
            missing = [x for x in expected.splitlines() if _shape(x) not in shapes]
            if missing:
                raise PageError(f"$ {text}\nno line like {missing[0]!r} in\n{printed}")
        elif not matches(expected, printed):
            raise PageError(f"$ {text}\n{_difference(expected, printed)}")

    def _environment(self) -> dict[str, str]:
        programs = Path(sys.executable).parent
        if self.clone is not None:
            programs = self.clone / ".venv" / "bin"
        path = f"{programs}{os.pathsep}{os.environ['PATH']}"
        settings = {"PATH": path, "REPOSITORY": str(ROOT), "PYTHONUNBUFFERED": "1"}
        if "CAN_INTERFACE" in self._set:
            bus = {"host": "127.0.0.1", "port": self._port(_HUB), "tcp_tune": True}
            settings["CAN_CONFIG"] = json.dumps(bus)
        if self.locale is not None:
            settings |= {"LC_ALL": "", "LC_MESSAGES": self.locale}
        return {**os.environ, **settings, **self._set}

    def _in_process(self, words: list[str], here: Path) -> tuple[int, str]:
        texts = [io.TextIOWrapper(io.BytesIO(), "utf-8", newline="") for _ in range(2)]
        with (
            _imports_below(self.folder.resolve()),
            chdir(here),
            patch.dict(os.environ, self._environment()),
            redirect_stderr(texts[0]),
            redirect_stdout(texts[1]),
        ):
            code = rtgen(words)
        printed = ""
        for text in texts:
            text.seek(0)
            printed += text.read()
        return code, printed

    def _in_shell(self, text: str, here: Path) -> tuple[int, str]:
        done = subprocess.run(
            ["bash", "-c", text],
            cwd=here,
            env=self._environment(),
            capture_output=True,
            text=True,
            timeout=_COMMAND_TIMEOUT,
            check=False,
        )
        return done.returncode, done.stderr + done.stdout

    def _start(self, text: str, expected: str, here: Path) -> None:
        process = subprocess.Popen(
            ["bash", "-c", f"exec {text}" if "=" not in text.split()[0] else text],
            cwd=here,
            env=self._environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self._background.append(process)
        assert process.stdout is not None
        for line in expected.splitlines():
            printed = process.stdout.readline().rstrip("\n")
            if not matches(line, printed):
                raise PageError(f"$ {text}\n{_difference(line, printed)}")


@contextmanager
def _imports_below(folder: Path) -> Iterator[None]:
    """Forget what is imported from a folder meanwhile, as the end of a process does."""
    path = [*sys.path]
    try:
        yield
    finally:
        sys.path[:] = path
        for name, module in [*sys.modules.items()]:
            places = [module.__file__] if getattr(module, "__file__", None) else []
            places += getattr(module, "__path__", ())
            if any(Path(each).is_relative_to(folder) for each in places):
                del sys.modules[name]
        invalidate_caches()


def _shape(line: str) -> str:
    """Return the line without its variable parts: numbers, octets, blanks."""
    words = re.sub(r"\b[0-9a-f]{2}\b|[-+]?\b[0-9][0-9a-zA-Z.]*\b", "", line)
    return " ".join(words.split())


def _check_part(text: str, whole: str) -> None:
    """Raise PageError unless the lines follow each other in a file, blank ones aside."""
    lines, all_lines = (
        "\n".join(filter(str.strip, each.splitlines())) for each in (text, whole)
    )
    if lines not in all_lines:
        raise PageError(_difference(lines, all_lines))


def _difference(expected: str, printed: str) -> str:
    return "\n".join(
        difflib.unified_diff(
            expected.strip("\n").splitlines(),
            printed.strip("\n").splitlines(),
            "page",
            "program",
            lineterm="",
        )
    )


def _import(text: str) -> None:
    """Execute the imports of installed packages. Raises SyntaxError for invalid Python."""
    for node in ast.parse(text).body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [alias.name for alias in node.names]
            module = node.module if isinstance(node, ast.ImportFrom) else names[0]
            if (module or "").partition(".")[0] in ("rtgen", "refnav", "refrobots"):
                exec(compile(ast.Module([node], []), "page", "exec"), {})


def _check_xml(text: str) -> None:
    prefixes = sorted(set(re.findall(r"[<\s/]([\w]+):\w", text)) - {"xml", "xmlns"})
    declared = " ".join(f'xmlns:{prefix}="urn:{prefix}"' for prefix in prefixes)
    if text.lstrip().startswith("<?xml"):
        etree.fromstring(text.encode())
    else:
        etree.fromstring(f"<page {declared}>{text}</page>".encode())


_CHECKS: dict[str, Callable[[str], object]] = {
    "python": _import,
    "toml": tomllib.loads,
    "json": json.loads,
    "xml": _check_xml,
}
