"""Scans and occupancy grids on the page's map."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ui_bench import QUIET, ROOT, until

import rtgen
from rtgen import runtime
from rtgen.cli.ui import CommandProject
from rtgen.model import System
from rtgen.runtime.rtc.profiles import ComponentProfile, data_port
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer]
OBSTACLES = ROOT / "specs/navigation/obstacles.xml"
GRID = """
module nav_msgs { module msg {
    struct Point { double x; double y; double z; };
    struct Quaternion { double x; double y; double z; double w; };
    struct Pose { Point position; Quaternion orientation; };
    struct MapMetaData {
        float resolution; unsigned long width; unsigned long height; Pose origin;
    };
    struct OccupancyGrid { MapMetaData info; sequence<int8> data; };
}; };
"""


@pytest.fixture
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


@pytest.mark.parametrize("page", [(1440, "light")], indirect=True)
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


class GridProject(CommandProject):
    """A system of one component, whose grid has two free cells, one occupied, one unknown."""

    def __init__(self, types: Any) -> None:
        super().__init__(QUIET, [str(OBSTACLES)])
        self._types = types

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[..., None]
    ) -> runtime.System:
        types = self._types

        class Mapper(runtime.Component):
            profile = ComponentProfile(
                "Mapper",
                rate=10.0,
                ports=(data_port("outport", "map", types.OccupancyGrid),),
            )

            def __init__(self, name: str) -> None:
                super().__init__(name)
                self.map = self.add_out_port("map", types.OccupancyGrid)

            def on_execute(self, ec_id: int) -> runtime.ReturnCode_t:
                grid = types.OccupancyGrid(data=[0, 0, 100, -1])
                grid.info.resolution, grid.info.width, grid.info.height = 2.0, 2, 2
                grid.info.origin.orientation.w = 1.0
                self.map.write(grid)
                return runtime.RTC_OK

        system = runtime.System(clock)
        system.add(Mapper("Mapper0"))
        system.activate("Mapper0")
        return system


class TestGrid:
    """An occupancy grid of four cells of 2 m."""

    @pytest.fixture
    def session(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Session:
        for artifact in rtgen.emit(rtgen.compile(GRID), "types").artifacts:
            file = tmp_path / str(artifact.path).replace("robots/", "grid_robots/")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(str(artifact.text))
        monkeypatch.syspath_prepend(tmp_path)
        types = importlib.import_module("grid_robots.nav_msgs.msg")
        return Session(GridProject(types), str(OBSTACLES), runtime.SimulatedClock)

    @pytest.mark.parametrize("page", [(820, "dark")], indirect=True)
    def test_its_cells_are_drawn(self, page: Any) -> None:
        page.get_by_role("tab", name="Map").click()
        line = page.get_by_role("status", name="Mapper0.map on the map")
        line.get_by_text("cells of 2 m").wait_for()
        shades = page.get_by_role("img", name="Map, scale bar").evaluate(
            """(canvas, far) => {
                const { width, height } = canvas;
                const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
                const at = (across, down) => {
                    const x = Math.round(width / 2 + across * height * far);
                    const y = Math.round(height / 2 + down * height * far);
                    return [...data.slice(4 * (y * width + x), 4 * (y * width + x) + 4)];
                };
                return [at(-1, 1), at(1, 1), at(-1, -1), at(1, -1)];
            }""",
            0.17,
        )
        free, beside, occupied, unknown = shades
        assert min(free[:3]) > 200
        assert min(beside[:3]) > 200
        assert max(occupied[:3]) < 60
        assert unknown[3] < 150
