"""All commands of the command line: help, examples, pages, completion by shells."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import chain, pairwise
from pathlib import Path

import click
import pytest

from rtgen.cli import application, run
from rtgen.cli.examples import EXAMPLES
from rtgen.cli.help import Command

ROOT = Path(__file__).parents[3]
CONSOLE = re.compile(r"```console\n(.*?)```", re.DOTALL)


def names() -> Iterator[str]:
    """Yield the commands as users type them: a group is a package below `rtgen.cli`.

    Modules of commands are not imported while tests are collected: the module `run` would replace
    the function in `rtgen.cli`.
    """
    context = click.Context(application, info_name="rtgen")
    for name in application.list_commands(context):
        module = find_spec(f"rtgen.cli.{name}")
        assert module is not None
        if module.submodule_search_locations is None:
            yield name
            continue
        group = application.get_command(context, name)
        if not isinstance(group, click.Group):
            yield name
            continue
        yield from (f"{name} {inner}" for inner in group.list_commands(context))


ALL = [*names()]


def command_of(name: str) -> click.Command:
    command: click.Command = application
    context = click.Context(application, info_name="rtgen")
    for word in name.split():
        assert isinstance(command, click.Group)
        inner = command.get_command(context, word)
        assert inner is not None
        command, context = inner, click.Context(inner, context, word)
    return command


SCREEN = (24, 80)
"""Lines and columns of a terminal."""
GROUPS = sorted({name.partition(" ")[0] for name in ALL if " " in name})
OLD_NAMES = ["adopt"]
EVERY = ["", *GROUPS, *ALL, *OLD_NAMES]


def help_of(name: str, capfd: pytest.CaptureFixture[str]) -> list[str]:
    assert run([*name.split(), "--help"]) == 0
    return capfd.readouterr().out.splitlines()


def test_the_help_of_rtgen_fits_a_screen(capfd: pytest.CaptureFixture[str]) -> None:
    lines = help_of("", capfd)
    assert len(lines) < SCREEN[0]
    sections = {
        "write": ["new", "generate", "fmt", "check", "diff"],
        "run": ["run", "ui", "ctl", "log"],
        "devices": ["can", "rpc", "conformance"],
        "files": ["convert", "docs", "graph"],
    }
    shown: dict[str, list[str]] = {}
    title = ""
    for line in lines[4:]:
        title = line[:9].strip() or title
        shown.setdefault(title, []).append(line[9:].split()[0])
    assert {title: shown[title] for title in sections} == sections
    more = next(line for line in lines if line.startswith("more"))
    named = {*more.replace(",", "").split()[1:], *chain(*sections.values())}
    assert named == {*application.list_commands(click.Context(application))}
    assert not named & {*OLD_NAMES}


@pytest.mark.parametrize("name", EVERY)
def test_a_help_is_short(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    lines = help_of(name, capfd)
    assert len(lines) < 60
    assert max(map(len, lines)) <= SCREEN[1]


@pytest.mark.parametrize("name", ALL)
def test_options_are_under_titles(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Each option once; those that all commands have come last, under one title."""
    assert isinstance(command_of(name), Command)
    lines = help_of(name, capfd)
    first = next(n for n, line in enumerate(lines) if re.fullmatch(r"\w+:", line))
    shown = [
        line.split()[0].rstrip(",") for line in lines[first:] if line.startswith("  -")
    ]
    options = {
        parameter.opts[0]
        for parameter in command_of(name).params
        if isinstance(parameter, click.Option) and not parameter.hidden
    }
    assert sorted(shown) == sorted({*options, "-h"})
    last = lines.index("Messages:")
    assert {line.split()[0] for line in lines[last + 1 : -2]} >= {
        "--diagnostics",
        "-h,",
    }


def test_the_options_of_runs_are_in_groups(capfd: pytest.CaptureFixture[str]) -> None:
    lines = help_of("run", capfd)
    titles = [line for line in lines if line.endswith(":") and not line.startswith(" ")]
    assert len(titles) >= 6
    sizes = [
        sum(line.startswith("  -") for line in lines[begin:end])
        for begin, end in pairwise([*map(lines.index, titles), len(lines)])
    ]
    assert sum(sizes) >= 37
    assert max(sizes) <= 15


def test_examples_belong_to_commands() -> None:
    assert EXAMPLES.keys() == {*EVERY}


@pytest.mark.parametrize("name", EVERY)
def test_a_help_ends_with_one_example_that_can_be_parsed(
    name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    lines = help_of(name, capfd)
    [example] = [line for line in lines if "example" in line.lower()]
    assert example == lines[-1]
    words = shlex.split(example.removeprefix("Example: "))
    assert words[: 1 + len(name.split())] == ["rtgen", *name.split()]
    command: click.Command = application
    context = click.Context(application, info_name="rtgen")
    rest = words[1:]
    while isinstance(command, click.Group):
        inner = command.get_command(context, rest[0])
        assert inner is not None
        command, rest = inner, rest[1:]
    # Raises UsageError for unknown options and arguments.
    command.make_context(example, rest)


@pytest.mark.parametrize("name", ALL)
def test_a_page_shows_what_the_command_prints(name: str) -> None:
    """Blocks of a page are run by tests/test_pages.py."""
    blocks = [
        block
        for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
        for block in CONSOLE.findall(page.read_text(encoding="utf-8"))
    ]
    call = re.compile(rf"^\$ (?:.*&& )?rtgen {name}(?:\s|$)", re.MULTILINE)
    assert any(call.search(block) for block in blocks)


COMPLETED = {
    "bash": ("complete -o nosort -F _rtgen_completion rtgen", "plain,generate"),
    "zsh": ("compdef _rtgen_completion rtgen", "plain\ngenerate\n"),
    "fish": ("complete --no-files --command rtgen", "plain,generate\t"),
}


@pytest.mark.parametrize("shell", COMPLETED)
def test_shells_complete_commands(
    shell: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    registered, answer = COMPLETED[shell]
    monkeypatch.setenv("_RTGEN_COMPLETE", f"{shell}_source")
    with pytest.raises(SystemExit, match="0"):
        run([])
    assert registered in capfd.readouterr().out
    monkeypatch.setenv("_RTGEN_COMPLETE", f"{shell}_complete")
    monkeypatch.setenv("COMP_WORDS", "rtgen gen")
    monkeypatch.setenv("COMP_CWORD", "gen" if shell == "fish" else "1")
    with pytest.raises(SystemExit, match="0"):
        run([])
    assert answer in capfd.readouterr().out


@pytest.mark.parametrize(
    ("words", "expected"),
    [("rtgen can sc", "scan"), ("rtgen check --diagnostics g", "github")],
)
def test_commands_of_groups_and_choices_are_completed(
    words: str,
    expected: str,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("_RTGEN_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
    with pytest.raises(SystemExit, match="0"):
        run([])
    assert capfd.readouterr().out == f"plain,{expected}\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_scripts_of_completion_are_read_by_their_shells(
    shell: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"{shell} is missing")
    monkeypatch.setenv("_RTGEN_COMPLETE", f"{shell}_source")
    with pytest.raises(SystemExit):
        run([])
    script = tmp_path / "script"
    script.write_text(capfd.readouterr().out)
    done = subprocess.run([program, "-n", str(script)], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
