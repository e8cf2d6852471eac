"""Report of a conformance test: as text, JSON, JUnit XML and HTML."""

from __future__ import annotations

import html
import json
from collections import Counter
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Final
from xml.etree import ElementTree

from rtgen.compiler.diagnostics.printable import printable
from rtgen.compiler.kit.translation import translated, translated_word
from rtgen.facts.columns import columns, padded


class Verdict(StrEnum):
    """The outcome of a check."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class Outcome:
    """Result of a check: `problems` if it failed, the reason if it was skipped."""

    check: str
    title: str
    clause: str
    verdict: Verdict
    tried: int = 0
    problems: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Report:
    """The outcomes of all checks of one subject, in order."""

    subject: str
    definition: str
    outcomes: tuple[Outcome, ...]

    @property
    def passed(self) -> bool:
        """Whether no check has failed."""
        return all(o.verdict is not Verdict.FAILED for o in self.outcomes)

    @property
    def counts(self) -> list[str]:
        """The numbers of checks by verdict."""
        counts = Counter(o.verdict for o in self.outcomes)
        return [f"{counts[v]} {v.value}" for v in Verdict]

    @property
    def summary(self) -> str:
        """The numbers of checks by verdict, in a line."""
        return ", ".join(self.counts)


def as_text(report: Report) -> str:
    """Return a line for each check, its problems below it, and the summary, in the language."""
    lines = []
    verdicts = {verdict: translated_word(verdict.value) for verdict in Verdict}
    first = max(map(columns, verdicts.values()))
    width = max((columns(o.check) for o in report.outcomes), default=0)
    for o in report.outcomes:
        tried = f" ({o.tried})" if o.tried else ""
        head = f"{padded(verdicts[o.verdict], first)}  {padded(o.check, width)}"
        lines.append(f"{head}  {translated(o.title)}{tried}")
        margin = " " * (first + 2 + width)
        lines += (f"{margin}  - {printable(translated(p))}" for p in o.problems)
    counted = ", ".join(map(translated, report.counts))
    return "\n".join([*lines, f"{printable(report.subject)}: {counted}", ""])


def as_json_text(report: Report) -> str:
    """Return the report as JSON, by the schema conformance.schema.json."""
    return f"{json.dumps({'passed': report.passed, **asdict(report)}, indent=2)}\n"


def as_junit(report: Report) -> str:
    """Return the report as JUnit XML: a test case for each check."""
    counts = Counter(o.verdict for o in report.outcomes)
    suite = ElementTree.Element(
        "testsuite",
        name=printable(report.subject),
        tests=str(len(report.outcomes)),
        failures=str(counts[Verdict.FAILED]),
        skipped=str(counts[Verdict.SKIPPED]),
    )
    for o in report.outcomes:
        case = ElementTree.SubElement(
            suite, "testcase", classname=printable(report.definition), name=o.check
        )
        if o.verdict is not Verdict.PASSED:
            tag = "failure" if o.verdict is Verdict.FAILED else "skipped"
            inner = ElementTree.SubElement(case, tag, message=o.title)
            inner.text = "\n".join(map(printable, o.problems))
    ElementTree.indent(suite)
    return f"{ElementTree.tostring(suite, 'unicode', xml_declaration=True)}\n"


def as_html(report: Report) -> str:
    """Return a self-contained page without scripts."""
    rows = "".join(
        f'<tr class="{o.verdict.value}"><td>{o.verdict.value}</td>'
        f"<td><code>{html.escape(o.check)}</code></td><td>{html.escape(o.title)}"
        f"{''.join(f'<div>{_escaped(p)}</div>' for p in o.problems)}</td>"
        f"<td>{o.tried or ''}</td><td>{html.escape(o.clause)}</td></tr>\n"
        for o in report.outcomes
    )
    title = _escaped(f"{report.subject}: {report.summary}")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{title}</title>\n<style>{_STYLE}</style></head>\n<body><h1>{title}</h1>\n"
        f"<p>{_escaped(report.definition)}</p>\n<table><thead><tr><th>verdict</th><th>check</th>"
        f"<th>title</th><th>tried</th><th>clause</th></tr></thead>\n<tbody>\n{rows}</tbody></table>\n"
        "</body></html>\n"
    )


def _escaped(text: str) -> str:
    return html.escape(printable(text))


_STYLE: Final = (
    ":root{color-scheme:light dark}body{font:15px system-ui,sans-serif;margin:2rem}"
    "table{border-collapse:collapse}td,th{text-align:left;vertical-align:top;padding:.3rem .8rem;"
    "border-bottom:1px solid #8886}.passed td:first-child{color:#2a7d2a}"
    ".failed td:first-child{color:#c62828;font-weight:bold}.skipped{opacity:.7}"
)
