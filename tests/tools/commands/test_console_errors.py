"""Errors that a command does not expect become findings in one place of the command line."""

from __future__ import annotations

import errno
import json
import os

import click
import pytest

from rtgen.cli import run as run_command
from rtgen.cli.options import with_console
from rtgen.compiler.backends.kit.quoting import UnquotableError
from rtgen.tools.kit.console import Console


def of_file(number: int, name: str | bytes | None) -> OSError:
    return OSError(number, os.strerror(number), name)


ERRORS = {
    "no file": (
        of_file(errno.ENOENT, "gone.idl"),
        (3, "ENV0001", "cannot use gone.idl: No such file or directory"),
    ),
    "octets": (
        of_file(errno.EACCES, b"\xff.idl"),
        (3, "ENV0001", "cannot use \udcff.idl: Permission denied"),
    ),
    "a long name": (
        of_file(errno.ENAMETOOLONG, "n" * 5_000),
        (2, "PRJ0015", f"'{'n' * 100}' has a name of more than 255 octets"),
    ),
    "a long path": (
        of_file(errno.ENAMETOOLONG, "n/" * 5_000),
        (2, "PRJ0015", f"'{'n/' * 50}' has more than 4000 octets"),
    ),
    "a text": (
        UnquotableError("a\0b", "XML"),
        (2, "PRJ0107", "XML cannot hold 'a\\x00b' here"),
    ),
}


def run_failing(error: Exception, *words: str) -> int:
    """Return the exit code of a command that raises an error."""

    @click.command()
    @with_console
    def failing(console: Console) -> int:
        raise error

    code: int = failing.main([*words], standalone_mode=False)
    return code


@pytest.mark.parametrize("kind", ERRORS)
def test_an_error_of_a_file_or_text_is_a_finding(
    kind: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RTGEN_DEBUG", raising=False)
    error, (code, rule, message) = ERRORS[kind]
    assert run_failing(error, "--diagnostics", "json") == code
    [finding] = json.loads(capfd.readouterr().err)
    assert (finding["code"], finding["message"]) == (rule, message)
    assert run_failing(error) == code
    assert f"error[{rule}]: " in capfd.readouterr().err


def test_other_errors_and_those_for_developers_are_raised(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("RTGEN_DEBUG", raising=False)
    for error in (of_file(errno.ECONNRESET, None), RuntimeError("x")):
        with pytest.raises(type(error)):
            run_failing(error)
    monkeypatch.setenv("RTGEN_DEBUG", "1")
    with pytest.raises(FileNotFoundError):
        run_failing(of_file(errno.ENOENT, "gone.idl"))


@pytest.mark.parametrize("words", [["check", "a\0b"], ["log", "info", "\0"], ["\0"]])
def test_arguments_have_no_null_character(
    words: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    assert run_command(words) == 2
    assert "an argument has no null character" in capfd.readouterr().err
