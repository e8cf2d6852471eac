"""Each page of the documentation agrees with the programs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import click
import pytest
from pages import (
    PAGES,
    ROOT,
    RUN_ELSEWHERE,
    Block,
    Command,
    Directive,
    PageError,
    Runner,
    commands,
    matches,
    parts,
)

from rtgen.cli import SECTIONS, application

LONG = frozenset(
    {
        *("api", "bags", "base-for-ros2", "can", "canopen", "canopen-python", "corba"),
        *("experiments", "openrtm", "profiles", "project", "recording"),
        *("reference-build", "rtc-for-ros2", "site", "small", "tecs", "templates"),
        "tutorial",
    }
)
"""Pages with runs of whole systems and networks, or many commands, which other tests run, too."""
README = ROOT / "README.md"
START = (
    *("first-component", "first-board", "first-can-device", "first-system"),
    "tutorial",
)
"""Pages that need no more than what `make demo` installs, and the tutorial."""
JAPANESE = (ROOT / "README.ja.md", *sorted((ROOT / "docs" / "ja").glob("*.md")))
EXAMPLES = sorted((ROOT / "examples").glob("*/README.md"))
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.nightly if page.stem in LONG else ())
        for page in [*PAGES, *EXAMPLES]
        if page.stem not in RUN_ELSEWHERE
    ],
    ids=lambda page: page.relative_to(ROOT).with_suffix("").as_posix(),
)
def test_a_page_shows_what_happens(page: Path, tmp_path: Path) -> None:
    Runner(tmp_path).run(page)


@pytest.mark.nightly
@pytest.mark.slow
def test_a_newcomer_starts_from_a_clean_clone(tmp_path: Path) -> None:
    fetch = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "click"]
    if subprocess.run(fetch, cwd=tmp_path, capture_output=True).returncode:
        pytest.skip("a package index is missing")
    clone = tmp_path / "clone"
    tracked = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True
    )
    for name in filter(None, tracked.stdout.split("\0")):
        (clone / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).exists():
            shutil.copy(ROOT / name, clone / name)
    Runner(tmp_path, clone).run(README)
    # As the tutorial says, which the other pages do not need.
    install = [clone / ".venv" / "bin" / "pip", "install", "-q", "pytest", "mypy"]
    for name in START:
        if name == "tutorial":
            subprocess.run(install, check=True)
        folder = tmp_path / name
        folder.mkdir()
        Runner(folder, clone).run(ROOT / "docs" / f"{name}.md")


def test_the_readme_is_read_in_a_few_minutes() -> None:
    text = README.read_text(encoding="utf-8")
    assert len(text.split()) <= 700
    lines = {
        part.language: len([line for line in part.text.splitlines() if line.strip()])
        for part in parts(README)
        if isinstance(part, Block) and part.language != "console"
    }
    assert lines == {"idl": 12, "python": 8, "cdl": 4, "toml": 5}


def anchors(page: Path) -> set[str]:
    """Return the anchors that a code host creates for the headings of a page."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    return {
        re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        for heading in HEADING.findall(text)
    }


@pytest.mark.parametrize(
    "page",
    [*PAGES, *EXAMPLES, *JAPANESE],
    ids=lambda page: page.relative_to(ROOT).with_suffix("").as_posix(),
)
def test_links_lead_somewhere(page: Path) -> None:
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        if "://" in link:
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.exists(), link
        assert ROOT in (target, *target.parents), link
        if anchor:
            assert anchor in anchors(target), link


def test_a_first_change_finds_what_its_page_names() -> None:
    """A constant is in a file that the same paragraph names."""
    page = (ROOT / "docs" / "first-change.md").read_text(encoding="utf-8")
    for paragraph in re.split(r"\n\n|\n(?=\d\. )", page):
        files = re.findall(r"`([\w/.]+\.py)`", paragraph)
        texts = [
            file.read_text(encoding="utf-8")
            for name in files
            for file in ROOT.glob(f"src/**/{name.removeprefix('src/')}")
        ]
        for constant in re.findall(r"`(_?[A-Z][A-Z_]+)`", paragraph):
            assert any(f"\n{constant}" in text for text in texts), constant


@pytest.mark.parametrize(
    "page",
    [*PAGES[1:], *EXAMPLES, ROOT / "docs" / "decisions" / "README.md"],
    ids=lambda page: page.relative_to(ROOT).with_suffix("").as_posix(),
)
def test_a_page_says_first_for_whom_it_is(page: Path) -> None:
    heading, blank, first, *_ = page.read_text(encoding="utf-8").splitlines()
    assert heading.startswith("# ")
    assert not blank
    assert re.fullmatch(r"\*For those who .+\.\*", first)


@pytest.mark.parametrize(
    "page",
    [page for page in JAPANESE if page.stem not in ("README", "words")],
    ids=lambda page: page.relative_to(ROOT).with_suffix("").as_posix(),
)
def test_a_japanese_page_shows_what_the_english_one_does(page: Path) -> None:
    english = README if page == JAPANESE[0] else ROOT / "docs" / page.name
    shown, expected = (
        [_without_output(part) for part in parts(each)] for each in (page, english)
    )
    assert shown == expected


def _without_output(part: Block | Directive) -> Block | Directive:
    """Return a part of a page without what commands print, which is in the language."""
    if isinstance(part, Block) and part.language == "console":
        typed = [line for line in part.text.splitlines() if line.startswith("$ ")]
        return replace(part, line=0, text="\n".join(typed))
    return replace(part, line=0)


@pytest.mark.slow
@pytest.mark.nightly
@pytest.mark.parametrize(
    "page", JAPANESE, ids=lambda page: page.relative_to(ROOT).with_suffix("").as_posix()
)
def test_a_japanese_page_shows_what_happens(page: Path, tmp_path: Path) -> None:
    Runner(tmp_path, locale="ja_JP.UTF-8").run(page)


def test_japanese_pages_lead_to_each_other() -> None:
    index = (ROOT / "docs" / "ja" / "README.md").read_text(encoding="utf-8")
    linked = {link.partition("#")[0] for link in LINK.findall(index)}
    assert {page.name for page in JAPANESE[1:]} - {"README.md"} <= linked
    for page in JAPANESE[1:]:
        heading, blank, first, *_ = page.read_text(encoding="utf-8").splitlines()
        assert heading.startswith("# ")
        assert not blank
        assert re.fullmatch(r"\*.+人のために。.*\*", first)


def test_every_command_has_a_row_in_its_section() -> None:
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    sections = dict(
        re.findall(r"^## (\w+)\n(.*?)(?=^## )", text, re.MULTILINE | re.DOTALL)
    )
    for title, summaries in SECTIONS.items():
        rows = re.findall(
            r"^\| `rtgen (\w+)", sections[title.capitalize()], re.MULTILINE
        )
        assert list(dict.fromkeys(rows)) == list(summaries)


@pytest.mark.parametrize("name", ["new", "log", "ctl", "can", "rpc"])
def test_the_row_of_a_group_has_its_commands(name: str) -> None:
    text = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    rows = re.findall(rf"^\| `rtgen {name} ([\w|\\-]+)", text, re.MULTILINE)
    context = click.Context(application, info_name="rtgen")
    group = application.get_command(context, name)
    assert isinstance(group, click.Group)
    listed = {each for row in rows for each in row.split("\\|")}
    assert listed == set(group.list_commands(context))


def test_every_extra_of_users_has_a_row() -> None:
    text = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    table = text[text.index("| extra |") :].partition("\n\n")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \|.*\| (yes|) ?\|$", table, re.MULTILINE))
    extras = {
        path: tomllib.loads((ROOT / path).read_text(encoding="utf-8"))["project"][
            "optional-dependencies"
        ]
        for path in ("pyproject.toml", "runtime/pyproject.toml")
    }
    developers = {"bench", "check", "release", "test"}
    assert rows.keys() == extras["pyproject.toml"].keys() - developers
    assert {name for name, both in rows.items() if both} == extras[
        "runtime/pyproject.toml"
    ].keys()


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    linked = {link.partition("#")[0] for link in LINK.findall(index)}
    assert {page.name for page in PAGES} - {"README.md"} <= linked


def test_commands_of_a_block_have_their_outputs() -> None:
    block = Block("console", "$ a b   # note\n1\n2\n$ c \\\n    d\n", 10)
    assert commands(block) == [Command("a b", "1\n2", 11), Command("c d", "", 14)]
    with pytest.raises(PageError, match=r"begins with '\$ '"):
        commands(Block("console", "a\n", 1))


@pytest.mark.parametrize(
    ("expected", "printed", "same"),
    [
        ("a\nb", "a\nb\n", True),
        ("a\n...\nd", "a\nb\nc\nd", True),
        ("took ... s", "took 0.3 s", True),
        ("a", "b", False),
        ("a.c", "abc", False),
    ],
)
def test_outputs_are_compared_with_gaps(
    expected: str, printed: str, same: bool
) -> None:
    assert matches(expected, printed) is same


def run_page(folder: Path, text: str) -> None:
    page = folder / "page.md"
    page.write_text(text, encoding="utf-8")
    Runner(folder).run(page)


NEW_FOLDER = "<!-- page: in a new folder -->\n\n"


def test_files_and_commands_of_a_page_are_tried(tmp_path: Path) -> None:
    written = "<!-- page: file a/b.txt -->\n\n```text\nhello\n```\n\n"
    shown = "```console\n$ cat a/b.txt\nhello\n```\n"
    run_page(tmp_path, NEW_FOLDER + written + shown)
    assert (tmp_path / "1" / "a" / "b.txt").read_text(encoding="utf-8") == "hello\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (NEW_FOLDER + "```console\n$ echo b\na\n```", r"page.md:3: \$ echo b\n"),
        (NEW_FOLDER + "```console\n$ false\n```", "ends with exit code 1"),
        ("```console\n$ true\n```", "no directive says where"),
        ("```\nx\n```", "unknown language"),
        ("```python\nfrom rtgen.runtime import Nothing\n```", "Nothing"),
        ("```toml\na =\n```", "page.md:1"),
        ("<!-- page: perhaps -->", "unknown directive"),
    ],
)
def test_what_differs_is_reported(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(PageError, match=message):
        run_page(tmp_path, text)


def test_what_a_page_starts_ends_with_it(tmp_path: Path) -> None:
    run_page(
        tmp_path,
        NEW_FOLDER
        + "```console\n$ sh -c 'echo $$ > id; echo ready; sleep 60' &\nready\n$ test -s id\n```\n",
    )
    number = int((tmp_path / "1" / "id").read_text(encoding="utf-8"))
    with pytest.raises(ProcessLookupError):
        os.kill(number, 0)
