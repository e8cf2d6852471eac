"""`rtgen docs`: a site of a project's interfaces, complete and without broken links."""

from __future__ import annotations

import posixpath
import re
import shutil
import subprocess
import sys
from contextlib import chdir
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
import yaml
from lxml import etree

from rtgen import api
from rtgen.cli import run
from rtgen.compiler.backends.kit.quoting.markdown import code, paragraphs, table, text
from rtgen.compiler.backends.wiring.routing import MAX_WIDTH
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.model import System, SystemComponent
from rtgen.tools.docs.pages import first_sentence
from rtgen.tools.docs.places import Kind, Places
from rtgen.tools.docs.site import site

ROOT = Path(__file__).parents[3]
GOLDEN = ROOT / "tests" / "golden" / "components" / "everything" / "input"
SVG_LINK = "{http://www.w3.org/2000/svg}a"


class Links(HTMLParser):
    """The addresses in links and resources of a page, and its anchors.

    `outside` are those of links to other sites.
    """

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.outside: list[str] = []
        self.anchors: set[str] = set()
        self.scripts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if tag == "a" and value and value.startswith(("http:", "https:")):
                self.outside.append(value)
            elif name in ("href", "src", "data") and value:
                self.addresses.append(value)
            if name == "id" and value:
                self.anchors.add(value)
            if name.startswith("on"):
                self.scripts.append(f"{name}={value}")


def links_of(page: Path) -> Links:
    found = Links()
    found.feed(page.read_text(encoding="utf-8"))
    return found


def check_links(folder: Path, *, leads_out: bool = False) -> int:
    """Check that every address in pages and pictures exists; return the number of files.

    `leads_out`: links may go to other sites.
    """
    pages = {page: links_of(page) for page in sorted(folder.rglob("*.html"))}
    addresses = [(page, a) for page, found in pages.items() for a in found.addresses]
    for picture in sorted(folder.rglob("*.svg")):
        root = etree.parse(picture).getroot()
        addresses += [(picture, a.get("href", "")) for a in root.iter(SVG_LINK)]
    assert leads_out or not any(found.outside for found in pages.values())
    for page, address in addresses:
        if page.name == "404.html":  # has absolute addresses, for a server's root
            continue
        assert "//" not in address, f"{page}: {address} needs a network"
        path, _, anchor = unquote(address).partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.is_file(), f"{page}: {address}"
        if anchor and target in pages:
            assert anchor in pages[target].anchors | {"__toc"}, f"{page}: {address}"
    return len(addresses)


@pytest.mark.nightly
def test_the_site_of_the_reference_build_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("material")
    monkeypatch.chdir(ROOT)
    assert run(["docs", "--build", "-q", "-o", str(tmp_path)]) == 0
    built = tmp_path
    assert check_links(built) > 5000
    system = (built / "systems" / "rh3_goal.svg").read_text(encoding="utf-8")
    assert 'href="../components/PathFollower.html"' in system
    names = {page.stem for page in (built / "components").glob("*.html")}
    assert {"PathFollower", "EposDriveProxy", "MotorBoardMarshaller"} <= names
    assert (built / "search" / "search_index.js").stat().st_size > 10_000


@pytest.mark.nightly
@pytest.mark.slow
def test_the_site_of_a_golden_project_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("material")
    monkeypatch.chdir(tmp_path)
    [definition, *_] = sorted(GOLDEN.glob("*.idl"))
    shutil.copy(definition, tmp_path)
    include = ["-I", str(GOLDEN), "-I", str(ROOT / "specs" / "idl")]
    assert run(["docs", *include, definition.name, "--build", "-q"]) == 0
    assert check_links(tmp_path / "build" / "site") > 100


@pytest.mark.slow
@pytest.mark.parametrize(
    "folder",
    [
        "build/site",
        *(
            pytest.param(each, marks=pytest.mark.nightly)
            for each in ("site", "build/docs")
        ),
    ],
)
def test_a_site_is_built_in_its_folder(
    folder: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Also where its pages were written before; never among files of a user."""
    pytest.importorskip("material")
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct A { long x; };\n")
    assert run(["docs", "a.idl", "-q", "-o", "build/docs"]) == 0
    assert not Path("build/docs/index.html").exists()
    for _ in range(2):
        capfd.readouterr()
        assert run(["docs", "a.idl", "--build", "-o", folder]) == 0
        assert capfd.readouterr().err == f"open {folder}/index.html\n"
    assert Path(folder, "index.html").is_file()
    assert not Path(folder, "site").exists()
    Path("mine").mkdir()
    Path("mine/notes.txt").write_text("mine")
    assert run(["docs", "a.idl", "--build", "-o", "mine"]) == 3
    assert "mine holds other files" in capfd.readouterr().err
    assert [path.name for path in Path("mine").iterdir()] == ["notes.txt"]


@pytest.mark.nightly
def test_the_documentation_of_rtgen_is_a_site(tmp_path: Path) -> None:
    pytest.importorskip("material")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-q", "-d"]
    done = subprocess.run(
        [*command, str(tmp_path)], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    pages = {page.stem for page in tmp_path.rglob("*.html")}
    assert pages >= {page.stem for page in (ROOT / "docs").glob("[a-z]*.md")}
    commands = (tmp_path / "reference" / "commands.html").read_text("utf-8")
    assert "rtgen can timing net.toml" in commands
    diagnostics = (tmp_path / "reference" / "diagnostics.html").read_text("utf-8")
    assert all(code in diagnostics for code in ("IDL0101", "CDL0009", "EDS0402"))
    assert check_links(tmp_path, leads_out=True) > 5000
    assert (tmp_path / "search" / "search_index.js").stat().st_size > 100_000
    english = (tmp_path / "tutorial.html").read_text("utf-8")
    japanese = (tmp_path / "ja" / "tutorial.html").read_text("utf-8")
    assert '<html lang="en"' in english
    assert '<html lang="ja"' in japanese
    assert 'href="ja/tutorial.html" hreflang="ja"' in english
    assert 'href="../tutorial.html" hreflang="en"' in japanese
    assert "Table of contents" not in japanese
    assert '<a href="../project.html">' in japanese
    words = (tmp_path / "words.html").read_text("utf-8")
    assert 'href="ja/words.html" hreflang="ja"' in words
    canopen = (tmp_path / "canopen.html").read_text("utf-8")
    assert 'href="ja/index.html" hreflang="ja"' in canopen


def test_words_of_japanese_sentences_are_searched(reference: Path) -> None:
    """The search compares the beginnings of words; Japanese has no spaces between them."""
    settings = yaml.safe_load((reference / "mkdocs.yml").read_text("utf-8"))
    [separator] = (
        plugin["search"]["separator"]
        for plugin in settings["plugins"]
        if isinstance(plugin, dict)
    )
    sentence = "RTCのサービスポートは、受け口の振る舞いを呼ぶ(heartbeat-consumer)。"
    words = list(filter(None, re.split(separator, sentence)))
    assert words == [
        *("RTC", "の", "サービスポート", "は", "受け", "口の", "振る", "舞いを"),
        *("呼ぶ", "(heartbeat", "consumer)"),
    ]


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Markdown of the reference build."""
    folder = tmp_path_factory.mktemp("reference")
    with chdir(ROOT):
        assert run(["docs", "-q", "-o", str(folder)]) == 0
    return folder


def test_pages_say_what_is_defined(reference: Path) -> None:
    docs = reference / "docs"
    component = (docs / "components" / "PathFollower.md").read_text("utf-8")
    assert "[<code>IIS::TimedPose2D</code>](../types/IIS.md#TimedPose2D)" in (
        component.replace("&#95;", "_").replace("IIS-TimedPose2D", "TimedPose2D")
    )
    assert "[<code>Odometry</code>](Odometry.md)" in component
    types = (docs / "types" / "RTC.md").read_text("utf-8")
    row = next(r for r in types.splitlines() if r.startswith("| <code>nsec</code>"))
    assert row.split(" | ")[2:6] == ["4", "4", "4", "4"]
    board = (docs / "signatures" / "sMotorBoard.md").read_text("utf-8")
    assert "| 2 | 2 | function id 2 |" in board
    assert "| 4 | 8 | speed: double64&#95;t |" in board
    device = (docs / "devices" / "EposDrive.md").read_text("utf-8")
    assert '<table class="bits">' in device
    assert "6064h" in device
    bus = (docs / "buses" / "rh3_beego.md").read_text("utf-8")
    assert "| load | " in bus


def test_pages_say_with_what_members_start() -> None:
    model = api.compile("""
        enum Colour { RED, @default_literal GREEN };
        @default(7) typedef long Seven;
        struct S { @default("a|b") string words; Seven usual; @optional Seven none; };
        union U switch (long) { case 1: @default("1, 2") sequence<long> many; };
        bitset B { @default(3) bitfield<4> low; };
        """)
    [page] = [f.text for f in site("x", model, ()) if "enum Colour" in f.text]
    lines = page.splitlines()
    assert "Values start with <code>GREEN</code>." in lines
    assert "Another name of <code>long</code>. Default: <code>7</code>." in page
    rows = {line.split(" | ")[0].strip("| "): line for line in lines if "|" in line}
    assert "Default: 7." in rows["<code>usual</code>"]
    assert "Default" not in rows["<code>none</code>"]
    assert page.count("Default: ") == 5


def test_the_index_describes_each_page(reference: Path) -> None:
    docs = reference / "docs"
    index = (docs / "index.md").read_text("utf-8")
    rows = [
        line.strip("| ").split(" | ") for line in index.splitlines() if "](" in line
    ]
    pages = {path.relative_to(docs).as_posix() for path in docs.rglob("*.md")}
    assert {re.findall(r"\]\(([^)]*)\)", row[0])[0] for row in rows} == pages - {
        "index.md"
    }
    described = {row[0].partition("]")[0]: row[1] for row in rows if len(row) == 2}
    assert described["[RTC"].startswith("1 ") is False
    assert "structs" in described["[RTC"]
    assert "kbit/s, load " in described["[rh3&#95;beego"]
    assert len(described) > 0.9 * len(rows)
    assert all(len(text) < 300 for text in described.values())


def test_pictures_fit_the_page(reference: Path) -> None:
    systems = reference / "docs" / "systems"
    for picture in systems.glob("*.svg"):
        page = picture.with_suffix(".md").read_text("utf-8")
        root = etree.parse(picture).getroot()
        width, height = (int(root.attrib[name]) for name in ("width", "height"))
        assert width <= MAX_WIDTH
        assert ('class="wiring whole"' in page) is (height <= MAX_WIDTH)
    assert "max-width: 100%" in (reference / "docs" / "site.css").read_text("utf-8")


def test_a_summary_is_the_first_sentence() -> None:
    for value, summary in {
        "Turns a joint. And more.": "Turns a joint.",
        "Limits, e.g. of speed,\nare kept. More": "Limits, e.g. of speed, are kept.",
        "One line\n\nAnother.": "One line",
        "関節を回す。止める。": "関節を回す。",
        "": "",
    }.items():
        assert first_sentence(value) == summary


def test_values_have_units() -> None:
    model = api.compile("""
        struct S { @unit("m") double length; };
        exception E { @unit("V") double voltage; };
        union U switch (long) { case 1: @unit("A") double current; };
        component C {
          @unit("rad") attribute double angle;
        };
        """)
    used = SystemComponent(
        instance="C0",
        type="C",
        id="",
        path_uri="",
        span=Span("s.xml", 1, 1, 1, 2),
        configuration=(("default", (("angle", "1.5"), ("other", "2"))),),
    )
    system = System(
        name="s", id="", file="s.xml", abstract="", components=(used,), connections=()
    )
    pages = "\n".join(file.text for file in site("x", model, (system,)))
    rows = {
        cells[0]: cells[1:]
        for line in pages.splitlines()
        if line.startswith("|")
        for cells in [line.strip("| ").split(" | ")]
    }
    assert rows["<code>length</code>"][1] == "m"
    assert rows["<code>voltage</code>"][1] == "V"
    assert rows["<code>1</code>"][2] == "A"
    values = [
        line for line in pages.splitlines() if line.startswith("| <code>C0</code>")
    ]
    assert values[1].endswith(" | rad |")
    assert values[2].endswith(" |   |")


@pytest.mark.sampled(0)
def test_the_same_definitions_give_the_same_files(
    reference: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    assert run(["docs", "-q", "-o", str(tmp_path / "other")]) == 0
    first, second = (
        {p.relative_to(f).as_posix(): p.read_bytes() for p in f.rglob("*.*")}
        for f in (reference, tmp_path / "other")
    )
    assert first == second
    assert not any(str(ROOT).encode() in data for data in first.values())


def test_links_of_markdown_lead_somewhere(reference: Path) -> None:
    docs = reference / "docs"
    settings = yaml.safe_load((reference / "mkdocs.yml").read_text("utf-8"))
    listed = {
        path
        for entry in settings["nav"]
        for chapter in entry.values()
        for path in (
            [chapter] if isinstance(chapter, str) else map(dict.popitem, chapter)
        )
    }
    paths = {p if isinstance(p, str) else p[1] for p in listed}
    assert paths == {p.relative_to(docs).as_posix() for p in docs.rglob("*.md")}
    for page in docs.rglob("*.md"):
        for link in re.findall(r"\]\(([^)]+)\)", page.read_text("utf-8")):
            path, _, anchor = link.partition("#")
            target = docs / posixpath.normpath(
                posixpath.join(page.parent.relative_to(docs).as_posix(), path)
            )
            assert target.is_file(), link
            if anchor:
                assert f"{{#{anchor}}}" in target.read_text("utf-8"), link


HOSTILE = [
    "<script>alert(1)</script>",
    "![x](http://example.org/x.png)",
    "[x](javascript:alert(1))",
    "`code` **bold** _it_ ~~no~~",
    "| a | b |",
    "# heading",
    "- item",
    "1. item",
    "    indented",
    "{{ 7 * 7 }} {% raw %}",
    "{: .class #id onclick=alert(1) }",
    "</td></tr></table>",
    "&lt;b&gt; &amp;",
    '" onmouseover="alert(1)',
    "--- \n***\n===",
    "http://example.org www.example.org a@example.org",
    "\x00\x1b[31m\u202e\u2028",
    "\\*\\",
    "[TOC]",
    "*[HTML]: abbreviation",
    "[^1]: note",
    ": definition",
    "!!! note",
]


class Shown(HTMLParser):
    """The text of a page, and its elements."""

    def __init__(self) -> None:
        super().__init__()
        self.text = ""
        self.elements: list[tuple[str, tuple[str, ...]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, tuple(name for name, _ in attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


def shown(source: str) -> Shown:
    markdown = pytest.importorskip("markdown")
    page = Shown()
    page.feed(markdown.markdown(source, extensions=["attr_list", "tables", "toc"]))
    return page


@pytest.mark.parametrize("hostile", HOSTILE)
def test_texts_come_out_as_texts(hostile: str) -> None:
    plain = " ".join(re.sub(r"[\x00-\x1f\u2028\u202e]", " ", hostile).split())
    for source, elements in (
        (text(hostile), [("p", ())]),
        (code(hostile), [("p", ()), ("code", ())]),
        (paragraphs(hostile), [("p", ())]),
    ):
        page = shown(source)
        assert page.elements == elements
        assert page.text.strip() == plain
    assert shown(f"## {text(hostile)} {{#x}}").elements == [("h2", ("id",))]
    cells = shown(table(("a", "b"), [(text(hostile), code(hostile))]))
    assert [tag for tag, _ in cells.elements].count("td") == 2
    assert cells.text.split("\n").count(plain) == 2


@pytest.mark.sampled(6)
@pytest.mark.parametrize("hostile", HOSTILE)
def test_a_site_with_hostile_descriptions_has_the_same_elements(hostile: str) -> None:
    assert elements_of(hostile) == elements_of("harmless")


def elements_of(description: str) -> list[list[tuple[str, tuple[str, ...]]]]:
    words = re.sub(r"\*/|[\x00-\x1f]", " ", description)
    model = api.compile(
        f"/** x {words} */ module M {{ /** x {words} */ struct S {{\n"
        f"/** x {words} */ long a; }}; /** x {words} */ interface I {{\n"
        f"/** x {words} */ void f(); }}; }};\n"
        f"/** x {words} */ component C {{ /** x {words} */ publishes M::S s; }};"
    )
    files = site(f"x {words}", model, ())
    return [shown(f.text).elements for f in files if f.path.endswith(".md")]


def test_names_that_differ_in_case_have_pages_of_their_own() -> None:
    places = Places()
    made = [places.page(Kind.COMPONENT, name) for name in ("Arm", "ARM", "arm", "Arm")]
    assert made == [
        "components/Arm",
        "components/ARM-2",
        "components/arm-3",
        "components/Arm",
    ]


@pytest.mark.parametrize("name", ["../up", "a/b", "index", "", "a b", "Ä", "x" * 300])
def test_any_name_has_a_path_of_plain_letters(name: str) -> None:
    path = Places().page(Kind.SYSTEM, name)
    assert re.fullmatch(r"systems/[A-Za-z0-9_-]{1,81}", path)
    assert path != "systems/index"


def test_definitions_with_errors_give_no_site(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("struct S { lon a; };\n")
    assert run(["docs", "a.idl"]) == 2
    assert not Path("build").exists()


def test_what_is_no_longer_made_is_removed_and_what_is_foreign_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.idl").write_text("component A {};\n")
    assert run(["docs", "a.idl"]) == 0
    pages = Path("build/docs/docs/components")
    (pages.parent / "mine.md").write_text("mine")
    Path("a.idl").write_text("component B {};\n")
    assert run(["docs", "a.idl"]) == 0
    assert [p.name for p in pages.iterdir()] == ["B.md"]
    assert (pages.parent / "mine.md").read_text() == "mine"
