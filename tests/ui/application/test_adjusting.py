"""Properties of connections that pages edit: judged, shown first, carried out, undone, saved."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import SequenceMatcher
from itertools import product
from pathlib import Path
from shutil import copy, copytree

import pytest
from ui_bench import ROOT, Bench, Page

from rtgen.compiler.frontends.profiles import rts_profile
from rtgen.facts.connector_properties import stated_data, violation
from rtgen.ui.connection_properties import parameters
from rtgen.ui.protocol import ui

INTERCHANGE = ROOT / "specs/experiments/interchange"
LENGTH = "dataport.inport.buffer.length"
DATAFLOW = "dataport.dataflow_type"
FULL = "dataport.inport.buffer.write.full_policy"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(ROOT)
    copytree(INTERCHANGE, tmp_path / "experiment")
    return tmp_path / "experiment"


@pytest.fixture
def bench(folder: Path) -> Iterator[Bench]:
    made = Bench(folder)
    yield made
    made.close()


def values(**stated: str) -> list[ui.Value]:
    return [ui.Value(name, text) for name, text in stated.items()]


def properties(bench: Bench, name: str) -> dict[str, str]:
    connector = bench.session.system.connector(name)
    return dict(getattr(connector, "properties", {}))


def changed(before: str, after: str) -> list[tuple[str, str]]:
    """Return the lines that differ."""
    old, new = before.splitlines(), after.splitlines()
    return [
        ("\n".join(old[a:b]), "\n".join(new[c:d]))
        for kind, a, b, c, d in SequenceMatcher(
            None, old, new, autojunk=False
        ).get_opcodes()
        if kind != "equal"
    ]


def first(bench: Bench) -> str:
    return bench.session.system.connectors[0].name


def ask(
    page: Page, name: str, stated: dict[str, str], *, carried_out: bool
) -> ui.Result:
    return page.ask("adjusted", ui.Adjust(name, values(**stated), carried_out))


def test_a_change_is_shown_before_it_is_made(bench: Bench, folder: Path) -> None:
    page, name = bench.page(), first(bench)
    before = properties(bench, name)
    told = ask(page, name, {LENGTH: "3"}, carried_out=False)
    assert told.done
    [change] = told.renamed
    lines = change.lines.splitlines()
    assert [line[0] for line in lines if line[0] in "+-"] == ["-", "+"]
    assert f'rtsExt:name="{LENGTH}" rtsExt:value="3"' in change.lines
    assert properties(bench, name) == before
    assert bench.session.edits.saved


@pytest.mark.parametrize(
    ("stated", "lines"),
    [
        ({LENGTH: "3"}, 1),
        pytest.param({LENGTH: ""}, 1, marks=pytest.mark.nightly),
        pytest.param({DATAFLOW: "pull"}, 1, marks=pytest.mark.nightly),
        ({DATAFLOW: "pull", LENGTH: "16", FULL: "block"}, 2),
        pytest.param(
            {
                "dataport.publisher.skip_count": "2",
                "dataport.publisher.push_policy": "skip",
            },
            1,
            marks=pytest.mark.nightly,
        ),
    ],
)
def test_a_change_is_carried_out_undone_and_saved(
    bench: Bench, folder: Path, stated: dict[str, str], lines: int
) -> None:
    page, name = bench.page(), first(bench)
    file = folder / "system.xml"
    text, before = file.read_text(), properties(bench, name)
    page.done("adjusted", ui.Adjust(name, values(**stated), True))
    after = {k: t for k, t in (before | stated).items() if t}
    assert properties(bench, name) == after
    assert ui.EventKind.EVENT_EDITS in page.kinds()
    page.done("undone", True)
    assert properties(bench, name) == before
    assert bench.session.edits.saved
    page.done("redone", True)
    assert properties(bench, name) == after
    page.done("file", "")
    assert len(changed(text, file.read_text())) == lines
    read = rts_profile.load(file)
    assert read.system is not None
    found = next(each for each in read.system.connections if each.name == name)
    for key, value in stated.items():
        default = "push" if key == DATAFLOW else None
        assert dict(found.properties).get(key) == (value or default)


def test_a_yaml_file_changes_in_the_same_place(tmp_path: Path) -> None:
    source = INTERCHANGE / "system.xml"
    text = rts_profile_yaml(source)
    file = tmp_path / "system.yaml"
    file.write_text(text)
    for each in INTERCHANGE.iterdir():
        if each.is_file() and each.name != "system.xml":
            copy(each, tmp_path)
    bench = Bench(file)
    page, name = bench.page(), first(bench)
    page.done("adjusted", ui.Adjust(name, values(**{LENGTH: "3"}), True))
    page.done("file", "")
    [(old, new)] = changed(text, file.read_text())
    assert "8" in old
    assert "3" in new
    bench.close()


def rts_profile_yaml(path: Path) -> str:
    from rtgen.compiler.frontends.kit import located_xml
    from rtgen.compiler.frontends.profiles import profile_yaml

    return profile_yaml.to_yaml(located_xml.parse(path.read_text(), str(path)))


REFUSED = (
    {LENGTH: "0"},
    {LENGTH: "many"},
    {DATAFLOW: "duplex"},
    {"dataport.subscription_type": "periodic"},
    {"dataport.nothing": "1"},
    {"dataport.io_mode": "new", "dataport.subscription_type": "flush"},
)


def test_what_no_connection_can_have_is_refused_and_changes_nothing(
    bench: Bench,
) -> None:
    page, name = bench.page(), first(bench)
    before = properties(bench, name)
    for stated, carried_out in product(REFUSED, (False, True)):
        told = ask(page, name, stated, carried_out=carried_out)
        assert not told.done, stated
        assert told.message
        assert properties(bench, name) == before
        assert bench.session.edits.saved
        assert bench.session.edits.undo_label == ""


def test_a_connection_that_only_the_run_has_changes_in_the_run_alone(
    bench: Bench, folder: Path
) -> None:
    page = bench.page()
    before = {each.name for each in bench.session.system.connectors}
    page.done("time", 20.0)
    made = next(
        each.name for each in bench.session.system.connectors if each.name not in before
    )
    told = ask(page, made, {LENGTH: "3"}, carried_out=True)
    assert told.done
    assert not told.renamed
    assert properties(bench, made)[LENGTH] == "3"
    assert bench.session.edits.saved


def test_a_page_that_may_only_look_changes_nothing(bench: Bench) -> None:
    page, name = bench.page(full=False), first(bench)
    told = ask(page, name, {LENGTH: "3"}, carried_out=True)
    assert told.code == "UIS0002"


def test_each_offered_value_is_one_that_a_connection_can_have() -> None:
    table = stated_data()
    for each in parameters():
        choices = (
            each.constraint.strip("()").split(",") if "(" in each.constraint else []
        )
        for text in (*choices, *([each.default_value] if each.default_value else [])):
            assert violation(table, each.name, text) is None, (each.name, text)
