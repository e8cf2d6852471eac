"""The command `rtgen lint`: runs the lint rules on definitions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import click

from rtgen import compiler
from rtgen.cli.common import (
    BAD_INPUT,
    NO,
    OK,
    Console,
    Definitions,
    project_of,
    with_console,
    with_definitions,
)
from rtgen.diagnostics import (
    Diagnostic,
    InputError,
    Severity,
    Span,
    has_errors,
    in_order,
)
from rtgen.project.rules import UNKNOWN_CODE


@click.command()
@with_definitions
@click.option(
    "--ignore", multiple=True, metavar="CODE", help="Leave a rule's findings out."
)
@click.option(
    "--select", multiple=True, metavar="CODE", help="Check a rule that is on demand."
)
@with_console
def lint(
    console: Console,
    definitions: Definitions,
    ignore: tuple[str, ...],
    select: tuple[str, ...],
) -> int:
    """Look for what is allowed in definitions, but better done otherwise.

    Exit code 0: nothing, or notes only; 1: warnings, those of reading the definitions included;
    2: errors. Rules are silenced one by one: --ignore CODE, or `[lint] ignore` in rtgen.toml;
    `[lint] select` is as --select. `rtgen explain CODE` describes a rule.
    """
    project = project_of(definitions)
    wrong = [*_unknown(ignore, "--ignore"), *_unknown(select, "--select")]
    for key, codes in (("ignore", project.ignored), ("select", project.selected)):
        wrong += _unknown(codes.keys(), f"[lint] {key}", codes)
    if wrong:
        raise InputError(wrong)
    result = compiler.read(project)
    found = list(result.diagnostics)
    if not has_errors(found):
        from rtgen.lint import lint as check

        selected = {code.upper() for code in (*select, *project.selected)}
        found += check(
            result.model, result.sources, select=selected, options=project.plugins
        )
    ignored = {code.upper() for code in (*ignore, *project.ignored)}
    found = in_order(
        d for d in found if d.severity is Severity.ERROR or d.code not in ignored
    )
    console.findings(found, result.sources)
    if has_errors(found):
        return BAD_INPUT
    return NO if any(d.severity is Severity.WARNING for d in found) else OK


def _unknown(
    codes: Iterable[str], where: str, spans: dict[str, Span] | None = None
) -> Iterator[Diagnostic]:
    """Findings for codes that no rule has."""
    from rtgen.diagnostics.explain import rules, similar

    for code in codes:
        if code.upper() not in rules():
            close = similar(code)
            yield UNKNOWN_CODE.at(
                spans[code] if spans else None,
                f"{where}: no rule has the code {code!r}",
                hint=f"did you mean {close[0]}?" if close else "see rtgen explain",
            )
