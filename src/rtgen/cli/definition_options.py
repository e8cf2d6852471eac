"""Options of the commands that read definitions."""

from __future__ import annotations

import functools
import gc
from collections.abc import Callable, Sequence

import click

from rtgen.cli.help import gathered
from rtgen.cli.options import P
from rtgen.cli.parameter_types import WholeRange
from rtgen.compiler.project import PRELUDES, TARGETS
from rtgen.facts.decoded_text import NAMES
from rtgen.tools.compiling.definitions import Definitions


def _macros(
    context: click.Context, parameter: click.Parameter, values: Sequence[str]
) -> tuple[tuple[str, str], ...]:
    macros = []
    for text in values:
        name, equals, value = text.partition("=")
        if not (name.isascii() and name.isidentifier()):
            raise click.BadParameter(
                f"{name!r} is not an identifier", context, parameter
            )
        macros.append((name, value if equals else "1"))
    return tuple(macros)


def with_definitions(command: Callable[..., int]) -> Callable[..., int]:
    """Add PATH and the options for reading definitions; the function gets `definitions`.

    The model lives until the end, so garbage collection is off meanwhile.
    """
    add = gathered(
        "definitions",
        Definitions,
        click.argument("paths", nargs=-1, metavar="[PATH]..."),
        click.option(
            "-I",
            "include",
            multiple=True,
            metavar="DIR",
            help="Search DIR for included files.",
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
            "--ignore-case-clashes",
            is_flag=True,
            help="Treat names that differ only in case as different names.",
        ),
        click.option(
            "--prelude",
            type=click.Choice(PRELUDES),
            help="Types that CDL files have without an import; default: kernel.",
        ),
        with_encoding,
    )
    return add(_without_garbage_collection(command))


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


def with_output(verb: str) -> Callable[[Callable[P, int]], Callable[P, int]]:
    """Add -o and --no-cache; the function gets `output` and `no_cache`."""

    def decorate(function: Callable[P, int]) -> Callable[P, int]:
        return click.option(
            "-o",
            "output",
            metavar="DIR",
            help=f"{verb} DIR/generated and DIR/src instead.",
        )(with_cache(function))

    return decorate


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
