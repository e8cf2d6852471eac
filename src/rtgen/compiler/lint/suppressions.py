"""Suppresses diagnostics by comments in the source, and by `rtgen.toml`.

`rtgen: ignore[CODE, CODE] reason` in a comment applies to the diagnostics in its line; in a line of
its own, to those in the next line with other content. Errors are never suppressed.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from rtgen.compiler.diagnostics import Diagnostic, Severity, Span
from rtgen.compiler.lint import rules
from rtgen.facts.cdl_files import CDL_SUFFIXES
from rtgen.facts.device_files import TEXT_SUFFIXES, XML_SUFFIXES
from rtgen.facts.idl_files import IDL_SUFFIXES

_COMMENT = re.compile(
    r"(?P<mark>//+|/\*+|#+|;+|<!--)[ \t]*rtgen:[ \t]*ignore\[(?P<codes>[^\]\n]{0,500})\]"
)
_CODE = re.compile(r"[^,\s]+")
_MARKS = {
    **dict.fromkeys(IDL_SUFFIXES, ("/",)),
    **dict.fromkeys(CDL_SUFFIXES, ("/",)),
    **dict.fromkeys(TEXT_SUFFIXES, (";",)),
    **dict.fromkeys((*XML_SUFFIXES, ".xml"), ("<",)),
}
_OTHER_MARKS = ("#",)


@dataclass(slots=True)
class _Suppression:
    span: Span
    code: str
    used: bool = False


@dataclass(slots=True)
class FilePattern(_Suppression):
    """A code with a pattern of files, from `[lint] per-file-ignores`."""

    pattern: str = ""


def suppressed(
    diagnostics: Iterable[Diagnostic],
    sources: Mapping[str, str],
    patterns: Sequence[FilePattern] = (),
    *,
    codes: Collection[str],
    active: Collection[str] | None,
    whole: bool = False,
) -> list[Diagnostic]:
    """Return the remaining diagnostics, and one for each suppression without effect.

    `codes` are those of all rules; `active` those of the rules that were run, None if that is
    unknown. `whole`: `sources` are all files that the patterns can match.
    """
    comments = {
        name: _in_text(name, text)
        for name, text in sources.items()
        if "ignore[" in text
    }
    remaining = [d for d in diagnostics if not _is_suppressed(d, comments, patterns)]
    if active is not None:
        written = [
            s for lines in comments.values() for ss in lines.values() for s in ss
        ]
        for each in [*written, *(patterns if whole else ())]:
            if each.code not in codes:
                message = f"no rule has the code {each.code!r}"
                remaining.append(rules.NO_EFFECT.at(each.span, message))
            elif not each.used and each.code in active:
                message = f"no finding of {each.code} is suppressed here"
                remaining.append(
                    rules.NO_EFFECT.at(each.span, message, hint="remove it")
                )
    return remaining


def _is_suppressed(
    d: Diagnostic,
    comments: Mapping[str, Mapping[int, list[_Suppression]]],
    patterns: Sequence[FilePattern],
) -> bool:
    if d.severity is Severity.ERROR or d.span is None:
        return False
    hit = False
    for written in comments.get(d.span.file, {}).get(d.span.line, ()):
        if written.code == d.code:
            written.used = hit = True
    for each in patterns:
        if d.code == each.code and fnmatchcase(d.span.file, each.pattern):
            each.used = hit = True
    return hit


def _in_text(name: str, text: str) -> dict[int, list[_Suppression]]:
    """Return the suppressions of a file, by the line that they apply to."""
    suffix = name[name.rfind(".") :].lower() if "." in name else ""
    marks = _MARKS.get(suffix, _OTHER_MARKS)
    suppressions: dict[int, list[_Suppression]] = {}
    pending: list[_Suppression] = []
    for number, line in enumerate(text.split("\n"), start=1):
        match = _COMMENT.search(line)
        if match is None or match["mark"][0] not in marks:
            if pending and line.strip():
                suppressions.setdefault(number, []).extend(pending)
                pending = []
            continue
        here = [
            _Suppression(
                Span(
                    name,
                    number,
                    match.start("codes") + code.start() + 1,
                    number,
                    match.start("codes") + code.end() + 1,
                ),
                code[0].upper(),
            )
            for code in _CODE.finditer(match["codes"])
        ]
        if line[: match.start()].strip():
            suppressions.setdefault(number, []).extend([*pending, *here])
            pending = []
        else:
            pending += here
    suppressions.setdefault(0, []).extend(pending)
    return suppressions
