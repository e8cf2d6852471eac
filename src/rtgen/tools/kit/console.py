"""The console of a command: standard error for diagnostics and messages, standard output."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, TextIO

from rtgen.compiler.diagnostics.printable import printable
from rtgen.compiler.kit.translation import (
    translated,
    translated_lines,
    translated_word,
)
from rtgen.facts.substitutes import registered
from rtgen.tools.kit.terminals import width_of

if TYPE_CHECKING:
    from rtgen.compiler.diagnostics import Diagnostic

_OUTPUT: ContextVar[list[str | bytes] | None] = ContextVar("output", default=None)
_DOCUMENTS = ("json", "sarif")
_INDENT = "  "
"""Before the further lines of a message that is wider than the terminal."""
_GAP = "  "
"""Between the columns of a table."""
_MAX_DEVIATIONS = 3
"""Deviations of a description of a device that are printed one by one."""


class Console:
    """Standard error with the options for it: form of diagnostics, colour, quiet, verbose."""

    __slots__ = ("_held", "colour", "form", "quiet", "verbose")

    def __init__(
        self,
        form: str = "text",
        colour: bool = False,
        quiet: bool = False,
        verbose: bool = False,
    ) -> None:
        self.form = form
        self.colour = colour
        self.quiet = quiet
        self.verbose = verbose
        self._held: list[Sequence[Diagnostic]] = []

    def findings(
        self,
        diagnostics: Sequence[Diagnostic],
        sources: Mapping[str, str] | None = None,
        *,
        fold: bool = True,
        summarised: bool = True,
    ) -> None:
        """Print diagnostics; forms with a single document (JSON, SARIF) are printed by `close`.

        A document is printed even without diagnostics. `fold`: the deviations of a description of a
        device are printed as one line, for people. `summarised`: `summary` follows.
        """
        if self.form in _DOCUMENTS:
            self._held.append(diagnostics)
        elif diagnostics:
            from rtgen.compiler.diagnostics.report import report

            folded: Mapping[str, str] = {}
            if fold and self.form == "text":
                diagnostics, folded = _folded(diagnostics)
            text = report(diagnostics, sources or {}, self.form, colour=self.colour)
            write_error(text)
            for file, what in folded.items():
                self.say(f"{file}: {what} are tolerated; rtgen lint shows them")
            if summarised:
                self.summary(diagnostics)

    def summary(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Print the number of diagnostics of each severity, for people."""
        if diagnostics:
            from rtgen.compiler.diagnostics.report import summary

            self.say(summary(diagnostics))

    def close(self) -> None:
        """Print the document of all diagnostics so far, if the form has one."""
        if self._held:
            from rtgen.compiler.diagnostics.report import report

            findings = [d for diagnostics in self._held for d in diagnostics]
            self._held.clear()
            write_error(report(findings, {}, self.form))

    def say(self, text: str) -> None:
        """Print lines for people in their language, unless quiet or in a machine-readable form."""
        self.repeat(_fitted(translated_lines(text), sys.stderr))

    def repeat(self, text: str) -> None:
        """Print lines as `say`, but as they are, since a component or a user has written them."""
        if text and not self.quiet and self.form == "text":
            write_error(printable(f"{text}\n", "\n\t"))

    def choice(self, question: str, answers: Sequence[str]) -> int | None:
        """Return the number of the answer that a person chooses, from 0 on.

        None if nobody is asked, since the command does not talk to a terminal, or chooses none.
        """
        if self.form != "text" or not (sys.stdin.isatty() and sys.stderr.isatty()):
            return None
        lines = [f"{i:3} {each}" for i, each in enumerate(answers, 1)]
        lines = [translated(question), *lines, f"{translated_word('number')}: "]
        sys.stderr.write(printable("\n".join(lines), "\n\t"))
        sys.stderr.flush()
        text = sys.stdin.readline().strip()
        if not text.isdecimal() or not 0 < int(text) <= len(answers):
            return None
        return int(text) - 1


@contextmanager
def noted_output() -> Iterator[list[str | bytes]]:
    """Within the block, what is printed is noted: texts on standard error, octets on output."""
    output: list[str | bytes] = []
    token = _OUTPUT.set(output)
    try:
        yield output
    finally:
        _OUTPUT.reset(token)


def is_noted() -> bool:
    """Return whether all that was printed is noted."""
    return _OUTPUT.get() is not None


def forget_output() -> None:
    """Note nothing further: what follows is printed past this module."""
    _OUTPUT.set(None)


def write_error(text: str) -> None:
    """Write text to standard error."""
    output = _OUTPUT.get()
    if output is not None:
        output.append(text)
    sys.stderr.write(text)


def _folded(
    diagnostics: Sequence[Diagnostic],
) -> tuple[Sequence[Diagnostic], Mapping[str, str]]:
    """Leave out the deviations of files that have many; return the rest, and what is left out.

    The first ones by which a part of the device is lost stay.
    """
    if not any(d.code.startswith("EDS") for d in diagnostics):
        return diagnostics, {}
    from rtgen.compiler.diagnostics import in_order
    from rtgen.compiler.frontends.eds.rules import DEVIATIONS, LOSSES

    deviating: dict[str, list[Diagnostic]] = {}
    for each in in_order(diagnostics):
        if each.span and each.code in DEVIATIONS:
            deviating.setdefault(each.span.file, []).append(each)
    left_out: set[Diagnostic] = set()
    folded = {}
    for file, those in sorted(deviating.items()):
        if len(those) > _MAX_DEVIATIONS:
            lost = [each for code in LOSSES for each in those if each.code == code]
            lost = lost[:_MAX_DEVIATIONS]
            hidden = set(those).difference(lost)
            if not hidden:
                continue
            folded[file] = (
                f"{len(hidden)} {'further ' if lost else ''}"
                f"deviation{'s' * (len(hidden) > 1)}"
            )
            left_out |= hidden
    rest = [each for each in diagnostics if each not in left_out]
    return rest, folded


def for_output(text: str) -> str:
    """Return a text for standard output; on a terminal, control characters are shown as U+FFFD."""
    return printable(text, "\n\t") if sys.stdout.isatty() else text


def write_text(text: str) -> None:
    """Write text for people to standard output, each line in their language."""
    write_out(_fitted(translated_lines(text), sys.stdout))


def _fitted(text: str, stream: TextIO) -> str:
    """Return lines of text that are not wider than a terminal; the rows of tables stay."""
    width = width_of(stream)
    if width is None or width <= len(_INDENT):
        return text
    from rtgen.facts.columns import columns, wrapped

    lines = []
    for line in text.split("\n"):
        if columns(line) <= width or line[:1].isspace() or _GAP in line:
            lines.append(line)
        else:
            lines.append(f"\n{_INDENT}".join(wrapped(line, width - len(_INDENT))))
    return "\n".join(lines)


def write_out(text: str | bytes) -> None:
    """Write text to standard output, or octets unchanged.

    The text is written in the encoding of a terminal, or that of PYTHONIOENCODING, and characters
    that it lacks are replaced; else in UTF-8, whatever the locale is. On a terminal, control
    characters are shown as U+FFFD. A closed pipe does not change the exit code.
    """
    try:
        sys.stdout.flush()
        if isinstance(text, str):
            text = _encoded(for_output(text))
        output = _OUTPUT.get()
        if output is not None:
            output.append(text)
        sys.stdout.buffer.write(text)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        discard_unread()


def _encoded(text: str) -> bytes:
    chosen = os.environ.get("PYTHONIOENCODING", "").partition(":")[0]
    if (chosen or sys.stdout.isatty()) and not is_unicode(sys.stdout):
        return text.encode(sys.stdout.encoding, registered())
    return text.encode("utf-8", "backslashreplace")


def is_unicode(stream: TextIO) -> bool:
    """Return whether a stream has all characters."""
    return stream.encoding.lower().startswith("utf")


def discard_unread() -> None:
    """Discard output still buffered for a reader that has gone, so that exit is silent."""
    from rtgen.runtime.failures import has_lost_its_reader

    for stream in (sys.stdout, sys.stderr):
        if has_lost_its_reader(stream):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
