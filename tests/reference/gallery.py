"""Makes docs/gallery.md: the wiring and the result of every system of the reference build.

`make gallery` draws everything anew; the tests check page and diagrams, which need no matplotlib.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from rtgen.cli import run as rtgen

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "gallery.md"
IMAGES = ROOT / "docs" / "images" / "gallery"


@dataclass(frozen=True)
class Entry:
    """A system: its file or folder, what it shows, and the options of the run for its picture.

    `{}` in the options stands for the picture; without it the picture is that of `--plot`. `series`
    (instance, port, member) are drawn over time, where nothing drives.
    """

    system: str
    shows: str
    options: tuple[str, ...] = ()
    series: tuple[tuple[str, str, str], ...] = ()

    @property
    def name(self) -> str:
        """What its pictures are called."""
        return Path(self.system).stem

    @property
    def wiring(self) -> Path:
        """The diagram."""
        return IMAGES / f"{self.name}_wiring.svg"

    @property
    def result(self) -> Path:
        """The picture of a run."""
        return IMAGES / f"{self.name}.png"


ENTRIES = (
    Entry("specs/navigation/rh3_goal.xml", "RH3 drives to one goal."),
    Entry("specs/navigation/rh3_path.xml", "RH3 drives along three waypoints."),
    Entry(
        "specs/navigation/obstacles.xml",
        "By hand, then round obstacles (Figure 2-4); the picture is the monitor's.",
        ("--set", "ObstacleMonitor0.picture={}"),
    ),
    Entry(
        "specs/navigation/map.xml",
        "RH2 along a route map, with the ceiling in view (Figure 2-5); the picture is"
        " that of DispPosition.",
        ("--set", "DispPosition0.picture={}"),
    ),
    Entry("specs/tecs/rh3_board.xml", "RH3 with its wheels on a TECS board."),
    Entry("specs/canopen/rh3_beego.xml", "RH3 on two CANopen drives."),
    Entry("specs/canopen/fourx.xml", "FourX on four CANopen drives."),
    Entry(
        "specs/canopen/pdo_linking.xml",
        "A motor follows a potentiometer, with no master between them (Figure 120).",
        series=(
            ("Palette0", "tpdo4", "Angle_reference"),
            ("Motor0", "tpdo2", "Position_actual_value"),
        ),
    ),
    Entry(
        "specs/interfaces/phase3.xml",
        "The third phase of the common interfaces (Figure 103).",
    ),
    Entry(
        "specs/experiments/interchange",
        "Joint experiment 1: every joystick drives every robot.",
    ),
    Entry(
        "specs/experiments/two_robots",
        "Joint experiment 1: one joystick, two robots, 18 steps.",
    ),
    Entry(
        "specs/experiments/chain",
        "Experiment A: a robot follows a robot that follows a robot.",
    ),
    Entry(
        "specs/experiments/leader_exchange",
        "Experiment B1: two followers exchange their leaders, twice.",
    ),
    Entry(
        "specs/experiments/one_to_four",
        "Experiment B2: after B1 one joystick drives all four robots.",
    ),
    Entry(
        "specs/embedded/environment.xml",
        "The embedded layer (Figures 122 and 123); the picture is the viewer's.",
        ("--set", "ObstacleMonitor0.picture={}"),
    ),
)


def page() -> str:
    """The text of the page."""
    parts = [
        "# Gallery\n\nEvery system of the reference build: how it is wired, and what came of a"
        " run in simulated time.\n`make gallery` draws all of it anew.\n"
    ]
    for entry in ENTRIES:
        images = f"images/gallery/{entry.name}"
        parts.append(
            f"\n## {entry.name}\n\n{entry.shows}\n\n"
            f"```\nrtgen run {entry.system}\n```\n\n"
            f"![Wiring of {entry.name}]({images}_wiring.svg)\n\n"
            f"![Result of {entry.name}]({images}.png)\n"
        )
    return "".join(parts)


def diagram(entry: Entry) -> str:
    """The wiring as SVG."""
    with TemporaryDirectory() as folder, chdir(ROOT):
        file = Path(folder) / "wiring.svg"
        code = rtgen(["graph", entry.system, "-o", str(file)])
        assert code == 0, entry.system
        return file.read_text(encoding="utf-8")


def draw(entry: Entry) -> None:
    """Runs the system and writes the picture."""
    if entry.series:
        draw_series(entry)
        return
    picture = str(entry.result)
    options = [option.format(picture) for option in entry.options]
    run(entry, *(options or ["--plot", picture]), "--csv", os.devnull)


def draw_series(entry: Entry) -> None:
    """Runs the system and draws members of its samples over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    with TemporaryDirectory() as folder:
        log = Path(folder) / "log.jsonl"
        run(entry, "--log", str(log))
        lines = [json.loads(line) for line in log.read_text("utf-8").splitlines()]
    for instance, port, member in entry.series:
        samples = [
            (line["t"] * 1e-9, line["value"][member])
            for line in lines
            if (line["instance"], line.get("port")) == (instance, port)
        ]
        axes.plot(*zip(*samples, strict=True), label=f"{instance}.{port} {member}")
    axes.set_xlabel("t [s]")
    axes.legend()
    figure.savefig(entry.result)


def run(entry: Entry, *options: str) -> None:
    """Runs the system in simulated time."""
    command = [sys.executable, "-m", "rtgen", "run", entry.system, *options]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)


def main() -> None:
    """Writes page, diagrams and pictures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    for entry in ENTRIES:
        print(entry.name, flush=True)
        entry.wiring.write_text(diagram(entry), encoding="utf-8", newline="\n")
        draw(entry)


if __name__ == "__main__":
    main()
