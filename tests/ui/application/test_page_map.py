"""Scans and occupancy grids on the page's map."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ui_bench import ROOT, WIDE, until

from rtgen import runtime
from rtgen.ui.session import Session

pytestmark = [pytest.mark.nightly, pytest.mark.slow, pytest.mark.peer]
OBSTACLES = ROOT / "specs/navigation/obstacles.xml"


@pytest.fixture(scope="module")
def shown() -> tuple[Path, None]:
    return OBSTACLES, None


class Hits:
    """Counts the rays of the last scan that hit something."""

    def __init__(self, system: runtime.System) -> None:
        self.count = -1
        system.add_listener(self)

    def __call__(self, record: object) -> None:
        """Ignore states."""

    def sample_writer(self, port: Any, elapsed: Callable[[], int]) -> Any:
        """Count the hits of the range finder's samples."""

        def write(scan: Any) -> None:
            if port.owner != "LRFCapture_URG0":
                return
            least, most = scan.config.minRange, scan.config.maxRange
            self.count = sum(r > 0 and least <= r <= most for r in scan.ranges)

        return write


@pytest.mark.parametrize("look", [WIDE], indirect=True)
def test_the_hits_of_a_scan_are_drawn(page: Any, session: Session) -> None:
    found: list[Hits] = []
    session.runner.submit(lambda: found.append(Hits(session.system)))
    page.get_by_role("tab", name="Map").click()
    line = page.get_by_role("status", name="LRFCapture_URG0.range on the map")
    until(page, lambda: bool(found) and found[0].count > 0)
    line.get_by_text("points").wait_for()
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="Play").wait_for()
    around = "points around RefHw0.pose"
    until(page, lambda: line.inner_text() == f"{found[0].count} {around}")
    obstacles = page.get_by_role(
        "status", name="Urg_to_Obstacles0.obstacles on the map"
    )
    obstacles.get_by_text(around).wait_for()
