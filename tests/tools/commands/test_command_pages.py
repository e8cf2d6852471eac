"""All commands of the command line: help, examples, pages, completion by shells."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import click
import pytest

from rtgen.cli import application, run
from rtgen.cli.examples import EXAMPLES

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


def test_examples_belong_to_commands() -> None:
    assert EXAMPLES.keys() <= {*ALL}


@pytest.mark.parametrize("name", ALL)
def test_help_ends_with_an_example_that_can_be_parsed(
    name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run([*name.split(), "--help"]) == 0
    _, found, examples = capfd.readouterr().out.partition("Example")
    assert found
    own = re.findall(rf"\brtgen {name}\b.*", examples)
    assert own
    for line in own:
        words = shlex.split(line, comments=True)[1 + len(name.split()) :]
        # Raises UsageError for unknown options and arguments.
        command_of(name).make_context(name, words)


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
