"""An occupancy grid of four cells of 2 m on the page's map."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from ui_bench import NARROW, QUIET, ROOT

from rtgen import api, runtime
from rtgen.compiler.model import System
from rtgen.ui.project_systems import CommandProject
from rtgen.ui.session import Session

pytestmark = [pytest.mark.slow, pytest.mark.peer, pytest.mark.nightly]
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


class GridProject(CommandProject):
    """A system of one component; of its grid's cells two are free, one is occupied, one unknown."""

    def __init__(self, types: Any) -> None:
        super().__init__(QUIET, [str(OBSTACLES)])
        self._types = types

    def assemble(
        self, profile: System, clock: runtime.Clock, failed: Callable[..., None]
    ) -> runtime.System:
        types = self._types

        class Mapper(runtime.Component, type_name="Mapper", rate=10.0):
            map = runtime.outport(types.OccupancyGrid)

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


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    folder = tmp_path_factory.mktemp("grid")
    for artifact in api.emit(api.compile(GRID), "types").artifacts:
        file = folder / str(artifact.path).replace("robots/", "grid_robots/")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(str(artifact.text))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        types = importlib.import_module("grid_robots.nav_msgs.msg")
        project = GridProject(types)
        yield Session(project, str(OBSTACLES), runtime.SimulatedClock)


@pytest.mark.parametrize("look", [NARROW], indirect=True)
def test_its_cells_are_drawn(page: Any) -> None:
    page.get_by_role("tab", name="Map").click()
    line = page.get_by_role("status", name="Mapper0.map on the map")
    line.get_by_text("cells of 2 m").wait_for()
    shades = page.get_by_role("img", name="Map, scale bar").evaluate(
        """(canvas, far) => {
            const { width, height } = canvas;
            const copy = new OffscreenCanvas(width, height);
            const pen = copy.getContext("2d", { willReadFrequently: true });
            pen.drawImage(canvas, 0, 0);
            const { data } = pen.getImageData(0, 0, width, height);
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
