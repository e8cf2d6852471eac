"""docs/sources.md leads from each part of the source documents to what carries it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
from pages import ROOT, Runner

PAGE = ROOT / "docs" / "sources.md"
LINK = re.compile(r"\[([^\]]+)\]\(([^)#]+)")
NUMBERED = re.compile(r"(Fig\.|Tables?) ([\d-]+(?:(?:, | to )\d[\d-]*)*)")
NUMBERS = {
    "A": {
        "Fig.": {str(n) for n in range(88, 124)},
        "Table": {str(n) for n in range(3, 9)},
    },
    "B": {
        "Fig.": {"1-1"}
        | {f"2-{n}" for n in range(1, 6)}
        | {f"3-{n}" for n in range(1, 12)},
        "Table": {"1-1"} | {f"3-{n}" for n in range(1, 26)},
    },
    "C": {
        "Fig.": {str(n) for n in range(1, 11)},
        "Table": {str(n) for n in range(1, 4)},
    },
}
"""The figures and tables of each document; A begins in the midst of a report."""

LONG = re.compile(
    r"python|rtgen run specs/(canopen|experiments|navigation/(obstacles|map))"
)
"""Commands that take seconds; their systems are run by tests/reference, too."""
SECTIONS = {
    "B": (
        *("1.1-3", "2.1-3", "3.1.1-8", "3.2.1-9", "3.3.1-8", "3.4.1-7"),
        *("3.5.1-8", "3.6.1-7", "4"),
    ),
    "C": (
        *("1", "2.1-2", "3", "3.1-3", "4.1-3", "4.3.1-2", "5", "5.1", "5.1.1-4"),
        *("6.1-2", "7"),
    ),
}
"""The sections of the documents that number them throughout."""


@dataclass(frozen=True)
class Row:
    """A part of a document, and what carries it."""

    document: str
    part: str
    definitions: str
    tests: str
    pictures: str
    commands: tuple[str, ...]


@cache
def rows() -> list[Row]:
    found = []
    document = ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            document = line[3]
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if document and len(cells) == 7 and cells[0] not in ("part", "---"):
            part, _, definitions, tests, pictures, run, _ = cells
            commands = tuple(re.findall(r"`([^`]+)`", run))
            found.append(Row(document, part, definitions, tests, pictures, commands))
    return found


def numbers(part: str, kind: str) -> set[str]:
    """Return the numbers of the figures or tables that a cell names."""
    found = set()
    for name, listed in NUMBERED.findall(part):
        if name.rstrip("s") == kind:
            for item in listed.split(", "):
                first, _, last = item.partition(" to ")
                chapter, _, begin = first.rpartition("-")
                end = (last or first).rpartition("-")[2]
                prefix = f"{chapter}-" if chapter else ""
                found |= {f"{prefix}{n}" for n in range(int(begin), int(end) + 1)}
    return found


@pytest.mark.parametrize("kind", ["Fig.", "Table"])
@pytest.mark.parametrize("document", NUMBERS)
def test_each_figure_and_table_has_its_row(document: str, kind: str) -> None:
    named: set[str] = set()
    for row in rows():
        if row.document == document:
            named |= numbers(row.part, kind)
    assert named == NUMBERS[document][kind]


def sections(text: str) -> set[str]:
    """Return the numbers of sections at the beginning of a cell, before figures and tables."""
    found = set()
    for item in re.split(r", (?=\d)", re.split(r",? ?(?:Fig\.|Tables?) ", text)[0]):
        if match := re.match(r"(\d(?:\.\d)*)(?: to \d(?:\.\d)*\.(\d))?", item):
            chapter, _, begin = match[1].rpartition(".")
            prefix = f"{chapter}." if chapter else ""
            last = int(match[2] or begin)
            found |= {f"{prefix}{n}" for n in range(int(begin), last + 1)}
    return found


@pytest.mark.parametrize("document", SECTIONS)
def test_each_section_has_its_row_or_is_named(document: str) -> None:
    text = PAGE.read_text(encoding="utf-8").partition(f"\n## {document}: ")[2]
    named = set()
    for part in re.findall(
        r"Not carried: (.*?)\.\s", text.partition("\n## ")[0], re.DOTALL
    ):
        for each in part.split("; "):
            named |= sections(each)
    for row in rows():
        if row.document == document:
            named |= sections(row.part)
    expected = set()
    for each in SECTIONS[document]:
        first, _, last = each.partition("-")
        expected |= sections(f"{first} to {first[:-1]}{last}" if last else first)
    assert named == expected


def test_the_chapters_of_the_report_have_rows() -> None:
    parts = [row.part for row in rows() if row.document == "A"]
    for number in range(1, 5):
        assert sum(part.startswith(f"({number})") for part in parts) == 2


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row.document} {row.part}")
def test_a_row_leads_to_what_carries_it(row: Row) -> None:
    assert row.commands
    for cell in (row.definitions, row.tests, row.pictures):
        links = LINK.findall(cell)
        assert links
        for name, link in links:
            target = (PAGE.parent / link).resolve()
            assert target.is_file(), link
            if cell == row.tests:
                text = target.read_text(encoding="utf-8")
                function = name.strip("`")
                assert function == target.stem or f"def {function}(" in text, name


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder for a copy of the repository, in which all commands run."""
    return tmp_path_factory.mktemp("sources")


@pytest.fixture(scope="module")
def runner(repository: Path) -> Runner:
    """Return the runner of a page, in the copy."""
    start = repository / "start.md"
    start.write_text("<!-- page: in the repository -->\n", encoding="utf-8")
    runner = Runner(repository)
    runner.run(start)
    return runner


@pytest.mark.sampled(4)
@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(command, marks=pytest.mark.nightly if LONG.match(command) else ())
        for command in dict.fromkeys(each for row in rows() for each in row.commands)
    ],
)
def test_the_command_of_a_row_succeeds(
    command: str, runner: Runner, repository: Path
) -> None:
    page = repository / "command.md"
    page.write_text(f"```console\n$ {command}\n```\n", encoding="utf-8")
    runner.run(page)
