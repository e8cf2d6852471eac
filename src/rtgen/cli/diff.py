"""The command `rtgen diff`: compares two versions of definitions by their meaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import click

from rtgen.cli.help import command
from rtgen.cli.options import with_console
from rtgen.cli.stages import with_stages
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.kit import stages
from rtgen.tools.diff.changes import Break
from rtgen.tools.diff.reading import (
    Source,
    at_revision,
    default_source,
    opened,
    source_of,
)
from rtgen.tools.kit.console import Console, write_out
from rtgen.tools.kit.exits import NO, OK, Refusal

_CLASSES = [str(each) for each in Break]


@command()
@click.argument("versions", nargs=-1, metavar="[OLD] [NEW]")
@click.option(
    "--against",
    metavar="REVISION",
    help="Use this git revision as OLD; the argument is the path to compare in both.",
)
@click.option(
    "--use",
    metavar="CLASS[,CLASS]...",
    help="Classes of changes for exit code 1: wire, source, stored, compatible; "
    "default: from rtgen.toml, else wire,source,stored.",
)
@click.option("--json", "json_wanted", is_flag=True, help="Print JSON (rtgen-diff/1).")
@with_console
@with_stages
def diff(
    console: Console,
    versions: tuple[str, ...],
    against: str | None,
    use: str | None,
    json_wanted: bool,
) -> int:
    """Compare two versions of definitions: changes, their classes, and affected readers.

    OLD and NEW are files, folders, or git revisions (main, HEAD~3, v1.2:specs/idl); OLD defaults to
    `[diff] against` in rtgen.toml, else to the main branch, NEW to the project of the working
    folder. Exit code 0: no change of the selected classes; 1: some
    changes; 2: errors. Allowed breaks are listed in rtgen.toml, each with a reason.
    """
    from contextlib import ExitStack

    from rtgen.tools.diff import report
    from rtgen.tools.diff.allowances import allowed
    from rtgen.tools.diff.compare import compare
    from rtgen.tools.diff.settings import settings

    chosen = settings()
    sources = _sources(versions, against, chosen.against)
    asked = _selected(use, chosen.use)
    with ExitStack() as stack:
        old, new = (stack.enter_context(opened(each)) for each in sources)
        with stages.stage("compare"):
            changes = compare(old, new)
    reasons, unused = allowed(changes, chosen.allowances)
    if json_wanted:
        from rtgen.compiler.inspection.indented_json import dumps

        labels = (sources[0].label, sources[1].label)
        write_out(dumps(report.as_json(labels, changes, reasons)) + "\n")
        console.findings(unused)
    else:
        findings = [report.finding(c, asked, reasons.get(c)) for c in changes]
        console.findings([*findings, *unused], {**old.sources, **new.sources})
        console.say(_summary(report.counts(changes, reasons), len(changes)))
    broken = any(report.is_asked(c, asked) for c in changes if c not in reasons)
    return NO if broken else OK


def _sources(
    versions: Sequence[str], against: str | None, default: tuple[str, Span] | None
) -> list[Source]:
    """Return the old and the new version."""
    if against is not None:
        if len(versions) > 1:
            raise Refusal("--against accepts one argument: the path to compare in both")
        old = source_of(against, revision=True)
        if not versions:
            return [old, Source("the working tree")]
        path = Path(versions[0])
        return [at_revision(old, path), source_of(versions[0])]
    if not versions:
        return [default_source(default), Source("the working tree")]
    if len(versions) > 2:
        raise Refusal("two versions are compared, OLD and NEW")
    sources = [source_of(word) for word in versions]
    return sources if len(sources) == 2 else [*sources, Source("the working tree")]


def _selected(use: str | None, default: tuple[Break, ...]) -> tuple[Break, ...]:
    """Return the selected classes."""
    if use is None:
        return default
    words = [word.strip().lower() for word in use.split(",")]
    for word in words:
        if word not in _CLASSES:
            raise Refusal(f"--use: {word!r} is none of {', '.join(_CLASSES)}")
    return tuple(Break(word) for word in words)


def _summary(counts: Mapping[str, int], number: int) -> str:
    if not number:
        return "no change of meaning"
    parts = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
    return f"{number} change{'s' * (number != 1)}: {parts}"
