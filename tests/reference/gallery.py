"""Generates docs/gallery.md: the wiring and the result of every system of the reference build.

`make gallery` draws everything anew; the tests check page and diagrams, which need no matplotlib.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections import defaultdict
from contextlib import chdir
from dataclasses import dataclass
from itertools import pairwise
from math import hypot
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rtgen.cli import run as rtgen
from rtgen.tools.running.trajectory import (
    Sample,
    add_legend,
    draw_trajectories,
    reproducible,
    stroke,
)

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "gallery.md"
IMAGES = ROOT / "docs" / "images" / "gallery"


@dataclass(frozen=True)
class Signal:
    """A member of the samples of a port (`member` is a path with dots), or its change per second.

    Without a port: the distance between two robots, or of a robot from its goal.
    """

    label: str
    instance: str
    port: str = ""
    member: str = ""
    rate: bool = False
    other: str = ""


@dataclass(frozen=True)
class Panel:
    """Signals over time, with the quantity and unit of the axis."""

    quantity: str
    signals: tuple[Signal, ...]


def wheels(instance: str, count: int = 2) -> Panel:
    """Return the speeds of a base's wheels, from their angles."""
    names = ("left", "right") if count == 2 else ("FL", "FR", "RL", "RR")
    return Panel(
        "wheel speed [rad/s]",
        tuple(
            Signal(f"{name} wheel", instance, "OutWheelAngle", f"data.{n}", rate=True)
            for n, name in enumerate(names)
        ),
    )


TO_GOAL = Panel("distance to goal [m]", (Signal("to the goal", ""),))
SPEED = Panel(
    "commanded speed [m/s], [rad/s]",
    (
        Signal("v [m/s]", "PathFollower0", "velocity", "data.vx"),
        Signal("w [rad/s]", "PathFollower0", "velocity", "data.va"),
    ),
)


def apart(*pairs: tuple[str, str]) -> Panel:
    """Return the distance between the robots of each pair."""
    return Panel(
        "distance [m]",
        tuple(Signal(f"{one} to {other}", one, other=other) for one, other in pairs),
    )


FOLLOWERS = tuple(
    apart((follower, "OmniWheel0"), (follower, "SegwayRmp0"))
    for follower in ("RefHard0", "BlackShip0")
)


@dataclass(frozen=True)
class Entry:
    """A system: its file or folder, its description, and the options of the run for its picture.

    `{}` in the options stands for the picture that a component draws. Without options the picture
    has the trajectories, if anything drives, and `panels` over time. Systems that run in real time
    together with another process (`alone` false) have no picture of a run.
    """

    system: str
    shows: str
    options: tuple[str, ...] = ()
    panels: tuple[Panel, ...] = ()
    drives: bool = True
    alone: bool = True

    @property
    def name(self) -> str:
        """The stem of the files of its pictures."""
        return Path(self.system).stem

    @property
    def wiring(self) -> Path:
        """The file of the diagram."""
        return IMAGES / f"{self.name}_wiring.svg"

    @property
    def result(self) -> Path:
        """The file of the picture of a run."""
        return IMAGES / f"{self.name}.png"

    @property
    def description(self) -> str:
        """The names of the picture's axes and curves, which are stored in its metadata."""
        return "\n".join(
            f"{panel.quantity}: {', '.join(s.label for s in panel.signals)}"
            for panel in self.panels
        )


ENTRIES = (
    Entry(
        "specs/navigation/rh3_goal.xml",
        "RH3 drives to one goal.",
        panels=(wheels("RefHardRh30"), TO_GOAL),
    ),
    Entry(
        "specs/navigation/rh3_path.xml",
        "RH3 drives along three waypoints.",
        panels=(SPEED,),
    ),
    Entry(
        "specs/navigation/obstacles.xml",
        "By hand, then round obstacles (Figure 2-4); the picture is the monitor's.",
        ("--set", "ObstacleMonitor0.picture={}"),
    ),
    Entry(
        "specs/navigation/map.xml",
        "RH3 along a route map, with the ceiling in view (Figure 2-5); the picture is"
        " that of DispPosition.",
        ("--set", "DispPosition0.picture={}"),
    ),
    Entry(
        "specs/tecs/rh3_board.xml",
        "RH3 with its wheels on a TECS board.",
        panels=(wheels("RefHardRh3Tecs0"), TO_GOAL),
    ),
    Entry(
        "specs/canopen/rh3_beego.xml",
        "RH3 on two CANopen drives: the commands of the base, and the reports of the drives.",
        panels=tuple(
            Panel(
                f"{side} drive [rad/s]",
                (
                    Signal(
                        "Target_velocity (RPDO 3)",
                        "RefHardRh3Canopen0",
                        f"{side}_target",
                        "Target_velocity",
                    ),
                    Signal(
                        "Velocity_actual_value (TPDO 2)",
                        f"{side.title()}Wheel0",
                        "tpdo2",
                        "Velocity_actual_value",
                    ),
                ),
            )
            for side in ("left", "right")
        ),
    ),
    Entry(
        "specs/canopen/rh3_pc.xml",
        "The same in real time, half of it: all but the drives"
        " ([how to run it](reference-build.md#canopen-wheels)).",
        alone=False,
    ),
    Entry(
        "specs/canopen/rh3_drives.xml",
        "The other half: the drives, in a process of their own.",
        alone=False,
    ),
    Entry(
        "specs/canopen/fourx.xml",
        "FourX on four CANopen drives: the speeds that they report.",
        panels=tuple(
            Panel(
                f"{end} drives [deg/s]",
                tuple(
                    Signal(
                        f"{side} drive (TPDO 2)",
                        f"{end}{side}Wheel0",
                        "tpdo2",
                        "Velocity_actual_value",
                    )
                    for side in ("Left", "Right")
                ),
            )
            for end in ("Front", "Rear")
        ),
    ),
    Entry(
        "specs/canopen/pdo_linking.xml",
        "A motor follows a potentiometer, with no master between them (Figure 120).",
        panels=(
            Panel(
                "angle sent [0.001 deg]",
                (Signal("TPDO 4 of Palette0", "Palette0", "tpdo4", "Angle_reference"),),
            ),
            Panel(
                "position [0.001 deg]",
                (
                    Signal(
                        "TPDO 2 of Motor0",
                        "Motor0",
                        "tpdo2",
                        "Position_actual_value",
                    ),
                ),
            ),
        ),
        drives=False,
    ),
    Entry(
        "specs/interfaces/phase3.xml",
        "The third phase of the common interfaces (Figure 103).",
        panels=(
            Panel(
                "speed [m/s], [rad/s]",
                (
                    Signal("v [m/s]", "TravelControl0", "information", "data.vx"),
                    Signal("w [rad/s]", "TravelControl0", "information", "data.va"),
                ),
            ),
        ),
    ),
    Entry(
        "specs/experiments/interchange",
        "Joint experiment 1: every joystick drives every robot.",
        panels=(
            Panel(
                "velocity command [m/s]",
                tuple(
                    Signal(f"v of {name}", name, "velocity", "v")
                    for name in (
                        "JoystickA0",
                        "JoystickB0",
                        "SegwayJoystick0",
                        "AistJoystick0",
                    )
                ),
            ),
        ),
    ),
    Entry(
        "specs/experiments/two_robots",
        "Joint experiment 1: one joystick, two robots, 18 steps.",
        panels=(apart(("RefHard0", "OmniWheel0")),),
    ),
    Entry(
        "specs/experiments/chain",
        "Experiment A: a robot follows a robot that follows a robot.",
        panels=(apart(("SegwayRmp0", "RefHard0"), ("OmniWheel0", "SegwayRmp0")),),
    ),
    Entry(
        "specs/experiments/leader_exchange",
        "Experiment B1: two followers exchange their leaders, twice.",
        panels=FOLLOWERS,
    ),
    Entry(
        "specs/experiments/one_to_four",
        "Experiment B2: after B1 one joystick drives all four robots.",
        panels=FOLLOWERS,
    ),
    Entry(
        "specs/experiments/phases",
        "A joystick of phase 1 drives a robot of phase 3, by an adapter.",
        panels=(
            Panel(
                "command [m/s], [rad/s]",
                (
                    Signal("v [m/s]", "VelocityAdapter0", "output", "data.vx"),
                    Signal("w [rad/s]", "VelocityAdapter0", "output", "data.va"),
                ),
            ),
        ),
    ),
    Entry(
        "specs/embedded/environment.xml",
        "The embedded layer (Figures 122 and 123); the picture is the viewer's.",
        ("--set", "ObstacleMonitor0.picture={}"),
    ),
)


def page() -> str:
    """Return the text of the page."""
    parts = [
        "# Gallery\n\n"
        "*For those who look for a system to start from, or want to see what is there.*\n\n"
        "Every system of the reference build: its wiring, and the result of a run"
        " in simulated time.\n`make gallery` draws all pictures.\n\n"
        "<!-- page: in the repository -->\n"
    ]
    for entry in ENTRIES:
        images = f"images/gallery/{entry.name}"
        wiring = f"![Wiring of {entry.name}]({images}_wiring.svg)\n"
        parts.append(f"\n## {entry.name}\n\n{entry.shows}\n\n")
        if entry.alone:
            parts.append(
                f"```console\n$ rtgen run {entry.system}\n```\n\n"
                f"{wiring}\n![Result of {entry.name}]({images}.png)\n"
            )
        else:
            parts.append(wiring)
    return "".join(parts)


def diagram(entry: Entry) -> str:
    """Return the wiring as SVG."""
    with TemporaryDirectory() as folder, chdir(ROOT):
        file = Path(folder) / "wiring.svg"
        code = rtgen(["graph", entry.system, "-o", str(file)])
        assert code == 0, entry.system
        return file.read_text(encoding="utf-8")


def draw(entry: Entry) -> None:
    """Run the system and write the picture."""
    if entry.options:
        picture = str(entry.result)
        options = [option.format(picture) for option in entry.options]
        run(entry, *options, "--csv", os.devnull)
        return
    with TemporaryDirectory() as folder:
        log, table = Path(folder) / "log.jsonl", Path(folder) / "table.csv"
        options = ["--csv", str(table)] if entry.drives else []
        run(entry, "--log", str(log), *options)
        lines = [json.loads(line) for line in log.read_text("utf-8").splitlines()]
        rows: list[dict[str, str]] = []
        if entry.drives:
            with table.open(encoding="utf-8", newline="") as stream:
                rows = list(csv.DictReader(stream))
    draw_result(entry, lines, rows)


def draw_result(
    entry: Entry, log: list[dict[str, Any]], rows: list[dict[str, str]]
) -> None:
    """Draw the picture of a run, from its log and its table of poses."""
    from matplotlib.figure import Figure

    robots, samples = trajectories(rows)
    count = len(entry.panels)
    with reproducible():
        if entry.drives:
            figure = Figure(figsize=(12.0, 6.4), layout="constrained")
            grid = figure.add_gridspec(max(count, 1), 2)
            map_axes = figure.add_subplot(grid[:, 0])
            draw_trajectories(map_axes, robots, samples)
            add_legend(figure, [map_axes])
            over_time = [figure.add_subplot(grid[n, 1]) for n in range(count)]
        else:
            figure = Figure(figsize=(9.0, 2.8 * count), layout="constrained")
            over_time = [figure.add_subplot(count, 1, n + 1) for n in range(count)]
        for axes, panel in zip(over_time, entry.panels, strict=True):
            for number, signal in enumerate(panel.signals):
                times, values = series(signal, log, robots, samples)
                axes.plot(
                    times,
                    values,
                    label=signal.label,
                    **stroke(number, len(panel.signals)),
                )
            axes.set_ylabel(panel.quantity)
            axes.grid(visible=True, alpha=0.3)
            axes.legend(
                loc="lower left",
                bbox_to_anchor=(0, 1),
                ncols=2,
                frameon=False,
                fontsize=9,
            )
        over_time[-1].set_xlabel("t [s]")
        figure.suptitle(entry.name)
        figure.savefig(entry.result, metadata={"Description": entry.description})


def trajectories(rows: list[dict[str, str]]) -> tuple[list[str], list[Sample]]:
    """Return the robots of a table of poses, and their positions."""
    robots = list(dict.fromkeys(row.get("robot", "robot") for row in rows))
    by_time: dict[str, list[dict[str, str]]] = defaultdict(list)
    for row in rows:
        by_time[row["t"]].append(row)
    samples = []
    for time, each in by_time.items():
        poses = tuple((float(r["x"]), float(r["y"]), float(r["theta"])) for r in each)
        goal = [each[0].get(f"goal_{name}") for name in ("x", "y", "theta")]
        known = all(goal)
        samples.append(
            Sample(
                float(time),
                poses,
                tuple(map(float, filter(None, goal))) if known else None,
            )
        )
    return robots, samples


def series(
    signal: Signal, log: list[dict[str, Any]], robots: list[str], samples: list[Sample]
) -> tuple[list[float], list[float]]:
    """Return the times and values of a signal."""
    if signal.port:
        return of_port(signal, log)
    times, values = [], []
    for sample in samples:
        if signal.other:
            one, two = (
                sample.poses[robots.index(name)]
                for name in (signal.instance, signal.other)
            )
        elif sample.goal is not None:
            one, two = sample.poses[0], sample.goal
        else:
            continue
        times.append(sample.t)
        values.append(hypot(one[0] - two[0], one[1] - two[1]))
    return times, values


def of_port(
    signal: Signal, log: list[dict[str, Any]]
) -> tuple[list[float], list[float]]:
    """Return times and values of a member of a port's samples, at most a few thousand."""
    times, values = [], []
    for line in log:
        if (line["instance"], line.get("port")) != (signal.instance, signal.port):
            continue
        value: Any = line["value"]
        for part in signal.member.split("."):
            value = value[int(part)] if isinstance(value, list) else value[part]
        times.append(line["t"] * 1e-9)
        values.append(float(value))
    step = max(1, len(times) // 2000)
    times, values = times[::step], values[::step]
    if signal.rate:
        values = [
            (after - before) / (late - early)
            for (early, late), (before, after) in zip(
                pairwise(times), pairwise(values), strict=True
            )
        ]
        times = times[1:]
    return times, values


def run(entry: Entry, *options: str) -> None:
    """Run the system in simulated time."""
    command = [sys.executable, "-m", "rtgen", "run", entry.system, *options]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)


def main() -> None:
    """Write page, diagrams and pictures."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    for entry in ENTRIES:
        print(entry.name, flush=True)
        entry.wiring.write_text(diagram(entry), encoding="utf-8", newline="\n")
        if entry.alone:
            draw(entry)


if __name__ == "__main__":
    main()
