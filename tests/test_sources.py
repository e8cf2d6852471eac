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


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", dict.fromkeys(command for row in rows() for command in row.commands)
)
def test_the_command_of_a_row_succeeds(
    command: str, runner: Runner, repository: Path
) -> None:
    page = repository / "command.md"
    page.write_text(f"```console\n$ {command}\n```\n", encoding="utf-8")
    runner.run(page)
