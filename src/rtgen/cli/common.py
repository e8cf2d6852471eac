"""Options shared by the commands, and the console for diagnostics and messages."""

from __future__ import annotations

import errno
import functools
import gc
import math
import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Concatenate, ParamSpec

import click
import msgspec

from rtgen import stages
from rtgen.backends.kit.quoting import UnquotableError
from rtgen.diagnostics import Diagnostic, InputError, ToolError
from rtgen.diagnostics.printable import printable
from rtgen.facts.decoded_text import NAMES
from rtgen.project import (
    PRELUDES,
    TARGETS,
    Project,
    load,
    path_finding,
    require_sources,
    with_arguments,
)

P = ParamSpec("P")

OK, NO, BAD_INPUT, FAILED = range(4)
INTERRUPTED = 130
"""Exit code after Ctrl-C and SIGTERM, as of a shell."""
"""Exit codes."""

_DOCUMENTS = ("json", "sarif")
_PORTS = 1 << 16


class Refusal(click.ClickException):
    """An argument of the command line that does not exist or has an invalid form."""

    exit_code = BAD_INPUT


def _in_words(minimum: float | None, maximum: float | None, *, is_open: bool) -> str:
    """Return a range in words, for help and messages (click writes `0<=x<=5`)."""
    if minimum is None:
        return "" if maximum is None else f"at most {maximum:.10g}"
    above = f"above {minimum:.10g}" if is_open else f"{minimum:.10g}"
    if maximum is None:
        return above if is_open else f"at least {above}"
    return f"{above} to {maximum:.10g}"


class Place(click.types.StringParamType):
    """`HOST` or `HOST:PORT`."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the text. Raises click.BadParameter."""
        text: str = super().convert(value, param, ctx)
        host, colon, port = text.rpartition(":")
        good = port.isascii() and port.isdecimal() and 0 < int(port) < _PORTS
        if not (host and good if colon else text):
            self.fail(f"'{text}' is not HOST or HOST:PORT.", param, ctx)
        return text


class WholeRange(click.IntRange):
    """A range of whole numbers."""

    def _describe_range(self) -> str:
        return _in_words(self.min, self.max, is_open=self.min_open)


class FiniteRange(click.FloatRange):
    """A range of numbers that excludes `nan` and `inf`."""

    def _describe_range(self) -> str:
        return _in_words(self.min, self.max, is_open=self.min_open)

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Convert the option's text. Raises click.BadParameter."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a number of that range.", param, ctx)
        return number


class ReportedError(Exception):
    """Ends a command whose failure has already been reported; `code` is the exit code."""

    def __init__(self, code: int) -> None:
        self.code = code
        super().__init__(code)


_MAX_DEVIATIONS = 3
"""Deviations of a description of a device that are printed one by one."""


class Console(msgspec.Struct, frozen=True):
    """Standard error with the options for it: form of diagnostics, colour, quiet, verbose."""

    form: str
    colour: bool
    quiet: bool
    verbose: bool = False
    _held: list[Sequence[Diagnostic]] = []

    def findings(
        self,
        diagnostics: Sequence[Diagnostic],
        sources: Mapping[str, str] | None = None,
        *,
        fold: bool = True,
    ) -> None:
        """Print diagnostics; forms with a single document (JSON, SARIF) are printed by `close`.

        A document is printed even without diagnostics. `fold`: the deviations of a description of a
        device are printed as one line, for people.
        """
        if self.form in _DOCUMENTS:
            self._held.append(diagnostics)
        elif diagnostics:
            from rtgen.diagnostics.report import report, summary

            folded: Mapping[str, int] = {}
            if fold and self.form == "text":
                diagnostics, folded = _folded(diagnostics)
            text = report(diagnostics, sources or {}, self.form, colour=self.colour)
            sys.stderr.write(text)
            for file, number in folded.items():
                self.say(
                    f"{file}: {number} deviations are tolerated; rtgen lint shows them"
                )
            if diagnostics and self.form == "text" and not self.quiet:
                sys.stderr.write(f"{summary(diagnostics)}\n")

    def close(self) -> None:
        """Print the document of all diagnostics so far, if the form has one."""
        if self._held:
            from rtgen.diagnostics.report import report

            found = [d for diagnostics in self._held for d in diagnostics]
            self._held.clear()
            sys.stderr.write(report(found, {}, self.form))

    def say(self, text: str) -> None:
        """Print a line for people, unless quiet or in a machine-readable form."""
        if text and not self.quiet and self.form == "text":
            sys.stderr.write(printable(f"{text}\n", "\n\t"))


def _folded(
    diagnostics: Sequence[Diagnostic],
) -> tuple[Sequence[Diagnostic], Mapping[str, int]]:
    """Leave out the deviations of files that have many; return the rest, and their numbers."""
    if not any(d.code.startswith("EDS") for d in diagnostics):
        return diagnostics, {}
    from rtgen.diagnostics import in_order
    from rtgen.frontends.eds.rules import DEVIATIONS

    numbers = Counter(
        d.span.file for d in in_order(diagnostics) if d.span and d.code in DEVIATIONS
    )
    folded = {file: n for file, n in sorted(numbers.items()) if n > _MAX_DEVIATIONS}
    rest = [
        d
        for d in diagnostics
        if not (d.code in DEVIATIONS and d.span and d.span.file in folded)
    ]
    return rest, folded


def for_output(text: str) -> str:
    """Return a text for standard output; on a terminal, control characters are shown as U+FFFD."""
    return printable(text, "\n\t") if sys.stdout.isatty() else text


def write_out(text: str | bytes) -> None:
    """Write text to standard output in UTF-8, regardless of the locale, or octets unchanged.

    On a terminal, control characters are shown as U+FFFD. A closed pipe does not change the exit
    code.
    """
    try:
        sys.stdout.flush()
        if isinstance(text, str):
            text = for_output(text).encode("utf-8", "backslashreplace")
        sys.stdout.buffer.write(text)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        discard_unread()


def discard_unread() -> None:
    """Discard output still buffered for a reader that has gone, so that exit is silent."""
    from rtgen.runtime.failures import has_lost_its_reader

    for stream in (sys.stdout, sys.stderr):
        if has_lost_its_reader(stream):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


def with_console(
    function: Callable[Concatenate[Console, P], int],
) -> Callable[..., int]:
    """Add the options of the console; turn exceptions into diagnostics and exit codes."""

    @click.option(
        "--diagnostics",
        "form",
        type=click.Choice(["text", "json", "sarif", "github"]),
        default="text",
        show_default=True,
        help="Format of diagnostics on standard error.",
    )
    @click.option("-q", "--quiet", is_flag=True, help="Print diagnostics only.")
    @click.option(
        "--color",
        type=click.Choice(["auto", "always", "never"]),
        default="auto",
        show_default=True,
        help="Colour of diagnostics.",
    )
    @functools.wraps(function)
    def wrapped(
        form: str, quiet: bool, color: str, *args: P.args, **kwargs: P.kwargs
    ) -> int:
        console = Console(form, _in_colour(color), quiet)
        try:
            return function(console, *args, **kwargs)
        except ReportedError as error:
            return error.code
        except InputError as error:
            console.findings(error.diagnostics)
            return BAD_INPUT
        except ToolError as error:
            if os.environ.get("RTGEN_DEBUG") == "1":
                raise
            from rtgen.project.rules import ENVIRONMENT

            console.findings([ENVIRONMENT.at(None, error.message, hint=error.hint)])
            return FAILED
        except UnquotableError as error:
            from rtgen.backends.kit.rules import UNQUOTABLE

            console.findings([UNQUOTABLE.at(None, str(error))])
            return BAD_INPUT
        except OSError as error:
            finding = _of_file(error)
            if finding is None:
                raise
            console.findings([finding])
            return FAILED if finding.code == "ENV0001" else BAD_INPUT
        finally:
            console.close()

    return wrapped


def _of_file(error: OSError) -> Diagnostic | None:
    """Return the diagnostic for a file that cannot be used; None if the error names no file."""
    if (
        not isinstance(error.filename, str | bytes)
        or os.environ.get("RTGEN_DEBUG") == "1"
    ):
        return None
    from rtgen.project.rules import ENVIRONMENT

    name = os.fsdecode(error.filename)
    if error.errno == errno.ENAMETOOLONG and (found := path_finding(name)) is not None:
        return found
    return ENVIRONMENT.at(None, f"cannot use {name}: {error.strerror}")


class Definitions(msgspec.Struct, frozen=True, kw_only=True):
    """The definitions named on the command line, with the options for reading them."""

    paths: tuple[str, ...]
    include: tuple[str, ...]
    define: tuple[tuple[str, str], ...]
    ignore_case_clashes: bool
    prelude: str | None
    encoding: str | None


def with_definitions(command: Callable[..., int]) -> Callable[..., int]:
    """Add PATH and the options for reading definitions; the function gets `definitions`.

    The model lives until the end, so garbage collection is off meanwhile.
    """

    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> int:
        given = {name: kwargs.pop(name) for name in Definitions.__struct_fields__}
        given["define"] = tuple(given["define"])
        return command(*args, definitions=Definitions(**given), **kwargs)

    function = _without_garbage_collection(wrapped)
    for decorate in (
        with_encoding,
        click.option(
            "--prelude",
            type=click.Choice(PRELUDES),
            help="Types that CDL files have without an import; default: kernel.",
        ),
        click.option(
            "--ignore-case-clashes",
            is_flag=True,
            help="Treat names that differ only in case as different names.",
        ),
        click.option(
            "-D",
            "define",
            multiple=True,
            metavar="NAME[=VALUE]",
            callback=_macros,
            help="Define a macro of the preprocessor.",
        ),
        click.option(
            "-I",
            "include",
            multiple=True,
            metavar="DIR",
            help="Search DIR for included files.",
        ),
        click.argument("paths", nargs=-1, metavar="[PATH]..."),
    ):
        function = decorate(function)
    return function


def with_encoding(function: Callable[..., int]) -> Callable[..., int]:
    """Add --encoding; the function gets `encoding`."""
    return click.option(
        "--encoding",
        "--kcode",
        type=click.Choice(NAMES),
        help="Encoding of files that do not tell theirs; default: from rtgen.toml, else auto.",
    )(function)


def _without_garbage_collection(function: Callable[P, int]) -> Callable[P, int]:
    @functools.wraps(function)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> int:
        enabled = gc.isenabled()
        gc.disable()
        try:
            return function(*args, **kwargs)
        finally:
            if enabled and not click.get_current_context().find_root().obj:
                gc.enable()

    return wrapped


def with_output(
    verb: str,
) -> Callable[[Callable[P, int]], Callable[P, int]]:
    """Add -o and --no-cache; the function gets `output` and `no_cache`."""

    def added(function: Callable[P, int]) -> Callable[P, int]:
        return click.option(
            "-o",
            "output",
            metavar="DIR",
            help=f"{verb} DIR/generated and DIR/src instead.",
        )(with_cache(function))

    return added


def with_cache(function: Callable[P, int]) -> Callable[P, int]:
    """Add --no-cache; the function gets `no_cache`."""
    return click.option(
        "--no-cache", is_flag=True, help="Neither read nor write the cache."
    )(function)


def with_target(function: Callable[P, int]) -> Callable[P, int]:
    """Add --target; the function gets `target`."""
    return click.option(
        "--target",
        type=click.Choice(TARGETS),
        help="Runtime of the components; default: from rtgen.toml, else embedded.",
    )(function)


def with_node_id(function: Callable[P, int]) -> Callable[P, int]:
    """Add --node-id; the function gets `node_id`."""
    return click.option(
        "--node-id",
        type=WholeRange(1, 127),
        metavar="N",
        help="Read CANopen devices as node N; default: a DCF's own node-id.",
    )(function)


def project_of(
    definitions: Definitions,
    output: str | None = None,
    add: bool = False,
    node_id: int | None = None,
    target: str | None = None,
) -> Project:
    """Return the project of the working folder, with the settings of the command line.

    `add`: the paths are added to the project's sources instead of replacing them.
    """
    with stages.stage("find definitions"):
        project = with_arguments(
            load(),
            paths=definitions.paths,
            include=definitions.include,
            define=definitions.define,
            ignore_case_clashes=definitions.ignore_case_clashes,
            prelude=definitions.prelude,
            encoding=definitions.encoding,
            output=output,
            add=add,
            node_id=node_id,
            target=target,
        )
        require_sources(project)
    return project


def _macros(
    context: click.Context, parameter: click.Parameter, values: Sequence[str]
) -> list[tuple[str, str]]:
    macros = []
    for text in values:
        name, equals, value = text.partition("=")
        if not (name.isascii() and name.isidentifier()):
            raise click.BadParameter(
                f"{name!r} is not an identifier", context, parameter
            )
        macros.append((name, value if equals else "1"))
    return macros


def _in_colour(choice: str) -> bool:
    if choice != "auto":
        return choice == "always"
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    forced = os.environ.get("FORCE_COLOR")
    return sys.stderr.isatty() if forced is None else forced != ""
