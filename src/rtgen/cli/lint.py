"""The command `rtgen lint`: runs the lint rules on definitions."""

from __future__ import annotations

from collections.abc import Sequence

import click
from msgspec.structs import replace

from rtgen.cli.definition_options import with_cache, with_definitions
from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.cli.stored_answers import with_answer
from rtgen.compiler import compilation
from rtgen.compiler.diagnostics import Diagnostic, InputError, Severity, has_errors
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit.memo import Memo
from rtgen.compiler.project import Project, behaviours, shown
from rtgen.compiler.project.rewriting import rewrite
from rtgen.tools.compiling.definitions import Definitions, project_of
from rtgen.tools.compiling.fixing import changed_files
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import BAD_INPUT, NO, OK

MAX_ROUNDS = 10
"""Maximum number of rounds of --fix, since a fix may make another one possible."""


@command()
@with_answer
@with_definitions
@with_cache
@click.option("--ignore", multiple=True, metavar="CODE", help="Disable a rule.")
@click.option(
    "--select",
    multiple=True,
    metavar="CODE",
    help="Enable a rule that is off by default.",
)
@click.option("--fix", is_flag=True, help="Apply safe fixes.")
@click.option("--diff", "as_diff", is_flag=True, help="Print the fixes as a diff.")
@with_console
@with_stages
def lint(
    console: Console,
    definitions: Definitions,
    no_cache: bool,
    ignore: tuple[str, ...],
    select: tuple[str, ...],
    fix: bool,
    as_diff: bool,
) -> int:
    """Run the lint rules on definitions.

    PATH is a definition file, a system, or a folder of them.

    Exit code 0: nothing, or only notes; 1: warnings, including those of reading the definitions;
    2: errors, including those with which generate would refuse them. --ignore CODE, or
    `[lint] ignore` in rtgen.toml, disables a rule; --select CODE, or `[lint] select`, enables one.
    A comment `rtgen: ignore[CODE]` disables a rule for its line.
    --fix changes the given files, --diff prints the changes instead.
    `rtgen explain CODE` describes a rule.
    """
    from rtgen.compiler.linting import unknown, unknown_codes

    project = project_of(definitions, judged=True)
    wrong = [*unknown(ignore, "--ignore"), *unknown(select, "--select")]
    wrong += unknown_codes(project)
    if wrong:
        raise InputError(wrong)
    whole = not definitions.paths
    diagnostics, result = _findings(project, select, ignore, whole)
    if as_diff and not has_errors(diagnostics):
        return _print_fixes(project, diagnostics, result)
    fixed = 0
    while fix and not has_errors(diagnostics):
        changes = changed_files(project, diagnostics, result)
        if not changes or fixed >= MAX_ROUNDS:
            break
        for change in changes:
            rewrite(change)
            console.say(f"fixed {shown(change.path)}")
        fixed += 1
        diagnostics, result = _findings(project, select, ignore, whole)
    console.findings(diagnostics, result.sources, fold=False)
    if has_errors(diagnostics):
        return BAD_INPUT
    return NO if any(d.severity is Severity.WARNING for d in diagnostics) else OK


def _findings(
    project: Project, select: Sequence[str], ignore: Sequence[str], whole: bool
) -> tuple[list[Diagnostic], FrontendResult]:
    """Return the diagnostics that are not suppressed, and the result that they refer to."""
    from rtgen.compiler.linting import findings
    from rtgen.compiler.systems import reading, timeline_checks

    memo = Memo()
    result = compilation.read(project, memo=memo)
    definitions = result
    of_outputs: Sequence[Diagnostic] = ()
    if not has_errors(result.diagnostics):
        definitions = compilation.read(project, lowered=True, memo=memo)
        of_outputs = _errors_of_outputs(project, definitions, whole)
    of_systems: Sequence[Diagnostic] = ()
    if project.systems:
        added = reading.added(
            definitions,
            project.systems,
            root=project.root,
            output=project.output,
            encoding=project.encoding,
            topics=project.ros2.topics,
        )
        of_systems = [
            *added.diagnostics[len(definitions.diagnostics) :],
            *timeline_checks.findings(
                project.systems,
                project.encoding,
                reading.models_of(definitions),
                behaviours.calls(project),
            ),
        ]
        result = replace(result, sources=added.sources)
    reported = {*result.diagnostics, *of_systems}
    of_outputs = [each for each in of_outputs if each not in reported]
    of_behaviours = behaviours.check_texts(project) if whole else []
    diagnostics = findings(
        project,
        result,
        beside=(*of_outputs, *of_systems, *of_behaviours),
        select=select,
        ignore=ignore,
        whole=whole,
    )
    return diagnostics, result


def _errors_of_outputs(
    project: Project, lowered: FrontendResult, whole: bool
) -> list[Diagnostic]:
    """Return the errors that only lowerings and back ends find, in definitions and systems.

    `whole`: those in other files of the project, too, such as rtgen.toml.
    """
    run = compilation.emitted(project, lowered)
    return [
        finding
        for finding in run.diagnostics
        if finding.severity is Severity.ERROR
        and (whole or (finding.span is not None and finding.span.file in run.sources))
    ]


def _print_fixes(
    project: Project, diagnostics: Sequence[Diagnostic], result: FrontendResult
) -> int:
    from rtgen.tools.compiling.diffs import diff

    changes = changed_files(project, diagnostics, result)
    write_out(diff(changes))
    return NO if changes else OK
