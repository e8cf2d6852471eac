"""The command `rtgen lint`: runs the lint rules on definitions."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

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
    write_out,
)
from rtgen.cli.fixing import changed_files
from rtgen.diagnostics import (
    Diagnostic,
    InputError,
    Severity,
    Span,
    has_errors,
    in_order,
)
from rtgen.diagnostics.explain import rules, similar
from rtgen.project import Project, shown
from rtgen.project.rewriting import rewrite
from rtgen.project.rules import UNKNOWN_CODE

MOST_ROUNDS = 10
"""How often --fix reads what it has changed, since a fix may make way for another."""

_READ_AND_LINTED = ("IDL", "CDL0", "EDS", "LINT")
"""What codes of findings begin with that this command finds."""


@click.command(epilog="Example: rtgen lint --fix specs")
@with_definitions
@click.option(
    "--ignore", multiple=True, metavar="CODE", help="Leave a rule's findings out."
)
@click.option(
    "--select", multiple=True, metavar="CODE", help="Check a rule that is on demand."
)
@click.option("--fix", is_flag=True, help="Carry out the safe fixes of findings.")
@click.option("--diff", "as_diff", is_flag=True, help="Print the fixes as a diff.")
@with_console
def lint(
    console: Console,
    definitions: Definitions,
    ignore: tuple[str, ...],
    select: tuple[str, ...],
    fix: bool,
    as_diff: bool,
) -> int:
    """Look for what is allowed in definitions, but better done otherwise.

    Exit code 0: nothing, or notes only; 1: warnings, those of reading the definitions included;
    2: errors. Rules are silenced one by one: --ignore CODE, or `[lint] ignore` in rtgen.toml;
    `[lint] select` is as --select. A comment `rtgen: ignore[CODE]` silences a rule for its line.
    --fix changes the files that were given, --diff shows what it would change.
    `rtgen explain CODE` describes a rule.
    """
    project = project_of(definitions)
    wrong = [*_unknown(ignore, "--ignore"), *_unknown(select, "--select")]
    for key, codes in (("ignore", project.ignored), ("select", project.selected)):
        wrong += _unknown(codes.keys(), f"[lint] {key}", codes)
    in_files = {code: span for _, code, span in project.ignored_in_files}
    wrong += _unknown(in_files, "[lint] per-file-ignores", in_files)
    if wrong:
        raise InputError(wrong)
    ignored = {code.upper() for code in (*ignore, *project.ignored)}
    whole = not definitions.paths
    found, sources = _findings(project, select, ignored, whole)
    if as_diff and not has_errors(found):
        return _print_fixes(project, found)
    fixed = 0
    while fix and not has_errors(found):
        changes = changed_files(project, found)
        if not changes or fixed >= MOST_ROUNDS:
            break
        for change in changes:
            assert change.new is not None
            rewrite(change.path, change.new)
            console.say(f"fixed {shown(change.path)}")
        fixed += 1
        found, sources = _findings(project, select, ignored, whole)
    console.findings(found, sources)
    if has_errors(found):
        return BAD_INPUT
    return NO if any(d.severity is Severity.WARNING for d in found) else OK


def _findings(
    project: Project, select: tuple[str, ...], ignored: Collection[str], whole: bool
) -> tuple[list[Diagnostic], Mapping[str, str]]:
    """The findings that are not silenced, with their fixes, and the texts that they are about."""
    from rtgen.lint import ON_DEMAND, fixes
    from rtgen.lint import lint as check
    from rtgen.lint.suppressions import FilePattern, suppressed

    result = compiler.read(project)
    found = list(result.diagnostics)
    active = None
    if not has_errors(found):
        selected = {code.upper() for code in (*select, *project.selected)}
        found += check(
            result.model, result.sources, select=selected, options=project.plugins
        )
        idle = {rule.code for rule in ON_DEMAND} - selected
        active = {c for c in rules() if c.startswith(_READ_AND_LINTED)} - idle
    patterns = [
        FilePattern(span, code, pattern=shown(project.root / pattern))
        for pattern, code, span in project.ignored_in_files
    ]
    found = suppressed(
        found, result.sources, patterns, known=rules(), active=active, whole=whole
    )
    left = (d for d in found if d.severity is Severity.ERROR or d.code not in ignored)
    return fixes.attached(in_order(left), result.sources), result.sources


def _print_fixes(project: Project, found: Sequence[Diagnostic]) -> int:
    from rtgen.cli.diffs import diff

    changes = changed_files(project, found)
    write_out(diff(changes))
    return NO if changes else OK


def _unknown(
    codes: Iterable[str], where: str, spans: dict[str, Span] | None = None
) -> Iterator[Diagnostic]:
    """Findings for codes that no rule has."""
    for code in codes:
        if code.upper() not in rules():
            close = similar(code)
            yield UNKNOWN_CODE.at(
                spans[code] if spans else None,
                f"{where}: no rule has the code {code!r}",
                hint=f"did you mean {close[0]}?" if close else "see rtgen explain",
            )
