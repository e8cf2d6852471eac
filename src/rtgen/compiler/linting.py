"""The diagnostics of `rtgen lint`: of reading and of the lint rules, except suppressed ones."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from rtgen.compiler.diagnostics import Diagnostic, Severity, Span, has_errors, in_order
from rtgen.compiler.diagnostics.explain import rules, similar
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.kit import stages
from rtgen.compiler.lint import OF_UNITS, ON_DEMAND, fixes
from rtgen.compiler.lint import lint as check
from rtgen.compiler.lint.rules import MISSPELT_UNIT, OTHER_FACTOR, UNKNOWN_UNIT
from rtgen.compiler.lint.suppressions import FilePattern, suppressed
from rtgen.compiler.project import Project, shown
from rtgen.compiler.project_rules import UNKNOWN_CODE
from rtgen.compiler.systems.connection_rules import RULES as SYSTEM_RULES

_PREFIXES = ("IDL", "CDL0", "EDS", "LINT", "TXT")
"""Prefixes of the codes that `rtgen lint` reports."""
_SYSTEM_CODES = frozenset(rule.code for rule in SYSTEM_RULES)
"""The codes of diagnostics about systems."""
UNIT_CODES = frozenset(
    rule.code for rule in (MISSPELT_UNIT, UNKNOWN_UNIT, OTHER_FACTOR)
)
"""The codes of warnings about units of definitions."""


def findings(
    project: Project,
    result: FrontendResult,
    *,
    beside: Sequence[Diagnostic] = (),
    select: Collection[str] = (),
    ignore: Collection[str] = (),
    whole: bool = True,
) -> list[Diagnostic]:
    """Return the diagnostics of a result of reading that are not suppressed, with fixes, in order.

    `beside` are those about the project's systems, whose texts are among the sources, and about its
    behaviours. `select` and `ignore` are codes in addition to those of rtgen.toml. `whole`: the
    result contains all files of the project.
    """
    diagnostics = [*result.diagnostics, *beside]
    active = None
    if not has_errors(result.diagnostics):
        selected = {code.upper() for code in (*select, *project.selected)}
        with stages.stage("lint rules"):
            diagnostics += check(
                result.model,
                result.sources,
                select=selected,
                options=project.plugins,
                target=project.target,
            )
        idle = {rule.code for rule in ON_DEMAND} - selected
        active = {c for c in rules() if c.startswith(_PREFIXES)} - idle
        active |= _SYSTEM_CODES
    remaining = wanted(
        project, diagnostics, result.sources, active=active, ignore=ignore, whole=whole
    )
    return fixes.attached(in_order(remaining), result.sources)


def of_check(project: Project, result: FrontendResult) -> list[Diagnostic]:
    """Return what `rtgen check` reports of lint rules: those of units, and errors.

    Other rules of rtgen warn and note (a test checks that), so only those of plug-ins run.
    """
    with stages.stage("lint rules"):
        diagnostics = check(
            result.model,
            result.sources,
            select={code.upper() for code in project.selected},
            options=project.plugins,
            target=project.target,
            checks=OF_UNITS,
        )
    return [
        each
        for each in diagnostics
        if each.severity is Severity.ERROR or each.code in UNIT_CODES
    ]


def wanted(
    project: Project,
    diagnostics: Sequence[Diagnostic],
    sources: Mapping[str, str],
    *,
    active: Collection[str] | None = None,
    ignore: Collection[str] = (),
    whole: bool = True,
) -> list[Diagnostic]:
    """Return the diagnostics that neither comments nor rtgen.toml suppress; errors stay.

    Suppressions of `active` codes without effect are reported; None: of none.
    """
    patterns = [
        FilePattern(span, code, pattern=shown(project.root / pattern))
        for pattern, code, span in project.ignored_in_files
    ]
    diagnostics = suppressed(
        diagnostics, sources, patterns, codes=rules(), active=active, whole=whole
    )
    ignored = {code.upper() for code in (*ignore, *project.ignored)}
    return [
        d for d in diagnostics if d.severity is Severity.ERROR or d.code not in ignored
    ]


def unknown_codes(project: Project) -> Iterator[Diagnostic]:
    """Yield diagnostics for codes in rtgen.toml that no rule has."""
    for key, codes in (("ignore", project.ignored), ("select", project.selected)):
        yield from unknown(codes, f"[lint] {key}", codes)
    in_files = {code: span for _, code, span in project.ignored_in_files}
    yield from unknown(in_files, "[lint] per-file-ignores", in_files)


def unknown(
    codes: Iterable[str], where: str, spans: dict[str, Span] | None = None
) -> Iterator[Diagnostic]:
    """Yield diagnostics for codes that no rule has."""
    for code in codes:
        if code.upper() not in rules():
            close = similar(code)
            yield UNKNOWN_CODE.at(
                spans[code] if spans else None,
                f"{where}: no rule has the code {code!r}",
                hint=f"did you mean {close[0]}?" if close else "see rtgen explain",
            )
