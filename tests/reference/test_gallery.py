"""The gallery shows the present wiring of every system."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from gallery import ENTRIES, IMAGES, PAGE, ROOT, Entry, diagram, page
from PIL import Image

from rtgen.compiler import compilation
from rtgen.compiler.project import load

PICTURES = [entry for entry in ENTRIES if entry.alone]


@pytest.fixture(scope="module")
def definitions() -> Iterator[None]:
    """Read the project's definitions once for all diagrams."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        read = compilation.read(load(), lowered=True)
        patch.setattr(compilation, "read", lambda project, lowered: read)
        yield


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `make gallery`"


@pytest.mark.sampled(2)
@pytest.mark.usefixtures("definitions")
@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_the_diagram_is_up_to_date(entry: Entry) -> None:
    assert entry.wiring.read_text(encoding="utf-8") == diagram(
        entry
    ), "run `make gallery`"


@pytest.mark.parametrize("entry", PICTURES, ids=lambda entry: entry.name)
def test_the_result_has_the_axes_and_curves_of_today(entry: Entry) -> None:
    with Image.open(entry.result) as picture:
        assert min(picture.size) > 400
        assert (
            picture.info.get("Description", "") == entry.description
        ), "run `make gallery`"


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.name)
def test_the_text_of_a_diagram_is_legible_in_a_column_of_a_page(entry: Entry) -> None:
    """9 px at least if the picture is scaled down to 830 px."""
    svg = entry.wiring.read_text(encoding="utf-8")
    sizes = [int(size) for size in re.findall(r'font-size="(\d+)"', svg)]
    found = re.search(r'<svg [^>]*width="(\d+)"', svg)
    assert found is not None
    assert min(sizes) * min(1, 830 / int(found[1])) >= 9


def test_buses_and_pdo_links_are_drawn() -> None:
    svg = (IMAGES / "pdo_linking_wiring.svg").read_text(encoding="utf-8")
    assert "CAN can0 · pdo_linking · 500 kbit/s" in svg
    assert "PaletteBoard0.tpdo4 → MotorUnit0.rpdo2" in svg
    assert svg.count('class="line pdo"') == 1


def test_connections_of_a_timeline_are_drawn() -> None:
    one, other = (
        (IMAGES / f"{name}_wiring.svg").read_text(encoding="utf-8")
        for name in ("leader_exchange", "one_to_four")
    )
    assert "48 s" in one
    assert "397 s" not in one
    assert "397 s" in other


def test_every_system_is_shown_and_nothing_else() -> None:
    wanted = {entry.wiring for entry in ENTRIES}
    wanted |= {entry.result for entry in ENTRIES if entry.alone}
    assert set(IMAGES.iterdir()) == wanted
    shown = {entry.system for entry in ENTRIES}
    experiments = {
        path.parent.relative_to(ROOT).as_posix()
        for path in (ROOT / "specs" / "experiments").glob("*/system.xml")
    }
    assert experiments <= shown
    systems = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "specs").rglob("*.xml")
        if path.name != "system.xml"
    }
    # The board alone is a part of rh3_board.
    assert systems - {"specs/tecs/board.xml"} == shown - experiments
