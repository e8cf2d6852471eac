"""No text of a definition or a device becomes markup or control characters of a report."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from hostile_texts import ALL

from rtgen.compiler.diagnostics.printable import printable
from rtgen.tools.conformance.report import (
    Outcome,
    Report,
    Verdict,
    as_html,
    as_json_text,
    as_junit,
    as_text,
)

HOSTILE = (*ALL, "PWNED\0", "\ud800PWNED", "\uffffPWNED")
HARMLESS = "word"


def report_of(text: str) -> Report:
    outcomes = tuple(
        Outcome("check", "what is checked", "clause", verdict, 1, (text, text))
        for verdict in Verdict
    )
    return Report(text, text, outcomes)


class _Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[object] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, attrs))

    def handle_endtag(self, tag: str) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)

    def handle_comment(self, data: str) -> None:
        self.tags.append(data)

    def handle_decl(self, decl: str) -> None:
        self.tags.append(decl)


@pytest.mark.parametrize("text", HOSTILE, ids=map(ascii, HOSTILE))
def test_texts_stay_texts(text: str) -> None:
    report, harmless = report_of(text), report_of(HARMLESS)

    page, twin = _Page(as_html(report)), _Page(as_html(harmless))
    assert page.tags == twin.tags
    assert "".join(page.texts) == "".join(twin.texts).replace(HARMLESS, printable(text))

    def shape(node: ElementTree.Element) -> object:
        return node.tag, sorted(node.attrib), [shape(child) for child in node]

    suite = ElementTree.fromstring(as_junit(report))
    assert shape(suite) == shape(ElementTree.fromstring(as_junit(harmless)))
    assert suite.attrib["name"] == printable(text)
    failure = suite.find(".//failure")
    assert failure is not None
    assert failure.text == f"{printable(text)}\n{printable(text)}"

    assert json.loads(as_json_text(report))["subject"] == text

    lines = as_text(report).split("\n")
    assert lines == as_text(harmless).replace(HARMLESS, printable(text)).split("\n")
    for form in (as_html, as_junit, as_json_text, as_text):
        form(report).encode()
