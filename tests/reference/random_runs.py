"""Random runs of the navigation, by seed, with accidents.

`python tests/reference/random_runs.py 500` executes the runs of seeds 1 to 500 and prints their
outcomes; `--first N` begins at another seed, `-v` prints every run. A run depends on its seed
alone, so a failing one can be repeated.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import hypot, pi
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from pipeline import GOAL, NAVIGATION, at_end, build, placed, profile

from refnav.geometry import Pose
from refnav.position_input import ALL_DONE
from refnav.room import Room, parse
from refrobots import iis, rtc
from rtgen.compiler import model
from rtgen.runtime import (
    ACTIVE_STATE,
    INACTIVE_STATE,
    SECOND,
    DataConnector,
    OutPort,
    Record,
    System,
)
from rtgen.tools.running.summary import Outcome, Tolerance

OBSTACLES = NAVIGATION / "obstacles.xml"
BODY = 0.45
"""Radius of the body [m]."""
NEAR = 0.05
"""A goal farther away than this must not count as met [m]."""
LIMIT = 0.5
"""Maximum age of data used for driving [s]: the default of the age limits."""
STOPPING = 0.15
"""Time from a velocity of 0 until the wheels stand, including the periods on the way [s]."""
BRAKING = 1.2
"""The same for RUN_STOP, which PathFollower executes with its `max_acc_v` [s]."""
LOOK = SECOND // 50
GIVEN_UP = 8 * SECOND
"""Time of standing after the last accident after which a base counts as stopped for good."""
MAX_DURATION = 150 * SECOND

FOLLOWED = {
    "OmniTo2WD0.min_path_Navigation0.min_path": None,
    "Navigation0.status_OmniTo2WD0.status": None,
    "Odometry0.OdometryPosition_OmniTo2WD0.current_position": None,
    "Odometry0.OdometryPosition_Navigation0.position": BRAKING,
    "Odometry0.OdometryPosition_PathFollower0.position": STOPPING,
    "Navigation0.path_PathFollower0.target_path": STOPPING,
}
"""Connections that may be cut, and how long the base may go on beyond the limit; None: forever."""
PLAIN = FOLLOWED | {
    "PathFollower0.velocity_RefHardRh30.InTargetVelocity": STOPPING,
    "RefHardRh30.OutWheelAngle_Odometry0.CurrentWheelAngle": LIMIT + STOPPING,
}
AVOIDING = FOLLOWED | {
    "PathFollower0.velocity_ObstaclesAvoidance0.velocity_in": LIMIT + STOPPING,
    "ObstaclesAvoidance0.velocity_out_SwitchInputRTC0.inVelAuto": LIMIT + STOPPING,
    "SwitchInputRTC0.outVel_MotorControl0.InTargetVelocity": STOPPING,
    "SwitchInputRTC0.outVel_CollisionDetection0.velocity": STOPPING,
    "MotorControl0.WheelSpeed_RefHw0.WheelSpeed": STOPPING,
    "MotorControl0.OutWheelAngle_Odometry0.CurrentWheelAngle": LIMIT + STOPPING,
    "LRFCapture_URG0.range_Urg_to_Obstacles0.range": STOPPING,
    "Urg_to_Obstacles0.obstacles_ObstaclesAvoidance0.obstacles": STOPPING,
    "Urg_to_Obstacles0.obstacles_CollisionDetection0.obstacles": STOPPING,
}


LONG = 1 << 31
"""Greater than the maximum of an IDL `long`, the type of the scanner's seed."""


@dataclass
class Run:
    """A run: its accidents and its outcome."""

    seed: int
    kind: str = ""
    accidents: list[str] = field(default_factory=list)
    ended: bool = False
    """Whether the last command is completed, as the components report."""
    missed: str = ""
    """Why `rtgen run` would not call the goal met although the run has ended."""
    away: float = 0.0
    least: float = 9.0
    """The least clearance between body and obstacles [m]."""
    contact: str = ""
    overdue: float = 0.0
    """Maximum time that the base has gone on beyond the stated age [s]."""
    overdue_by: str = ""
    words: list[str] = field(default_factory=list)
    under_way: bool = False
    """Whether the base was still moving at the maximum duration."""

    @property
    def met(self) -> bool:
        """Whether the exit code of `rtgen run` would be 0."""
        return self.ended and not self.missed

    @property
    def became(self) -> str:
        """A short description of the outcome."""
        if self.met:
            return "met"
        if self.under_way:
            return "still under way when the time was over"
        return "ended elsewhere, and said so" if self.ended else "stopped with a reason"

    @property
    def faults(self) -> list[str]:
        """The violations of safety rules."""
        found = []
        if self.contact or self.least < 0.0:
            found.append(f"collision ({self.contact or self.least})")
        if self.met and self.away > NEAR:
            found.append(f"met {self.away:.3f} m from the goal")
        if self.overdue > 0.0:
            found.append(f"{self.overdue:.2f} s beyond the age of {self.overdue_by}")
        if not self.ended and not self.under_way and not self.words:
            found.append("stopped without a word")
        return found


class _Watch:
    """Checks every 20 ms, from outside of the components."""

    def __init__(
        self, system: System, run: Run, links: dict[str, float | None]
    ) -> None:
        self._system = system
        self._run = run
        self._room = Room(())
        self._links = {
            name: slack for name, slack in links.items() if slack is not None
        }
        self._written: dict[str, int] = {}
        self._told_to_stop = False
        self._delivered = dict.fromkeys(self._links, 0)
        connectors = {
            name: connector
            for name in self._links
            for connector in [system.connector(name)]
            if isinstance(connector, DataConnector)
        }
        self._sources = {name: str(c.source) for name, c in connectors.items()}
        self._readers = {
            name: str(c.target).partition(".")[0] for name, c in connectors.items()
        }
        self.cut: set[str] = set()
        self.still_since = 0
        self.base = "RefHw0" if run.kind == "obstacles" else "RefHardRh30"
        system.add_listener(self)
        system.every(LOOK, self._look)

    def furnish(self, room: Room) -> None:
        """Store the obstacles in the room."""
        self._room = room

    def __call__(self, record: Record) -> None:
        """Ignore states."""

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """Note that a port has sent a sample."""
        source = str(port)
        self._written[source] = 0

        def note(value: Any) -> None:
            self._written[source] = elapsed()

        def note_waypoint(value: rtc.Path) -> None:
            self._written[source] = elapsed()
            self._told_to_stop = value.type == iis.TravelMode.RUN_STOP

        return note_waypoint if source == "Navigation0.path" else note

    def _look(self) -> None:
        now, system, run = self._system.time, self._system, self._run
        pose = system.observable(f"{self.base}.truth")
        run.least = min(run.least, self._room.distance(pose[0], pose[1]) - BODY)
        moving = max(map(abs, system.observable(f"{self.base}.wheels"))) > 0.05
        if moving:
            self.still_since = now
        for name, slack in self._links.items():
            # A reader that was switched off has no data to go by, and none that gets old.
            off = system.state(self._readers[name]) is INACTIVE_STATE
            if off or name not in self.cut:
                self._delivered[name] = self._written[self._sources[name]]
            if name.startswith("Navigation0.path_") and self._told_to_stop:
                slack = BRAKING
            overdue = (now - self._delivered[name]) / SECOND - LIMIT - slack
            if moving and overdue > run.overdue:
                run.overdue, run.overdue_by = overdue, name


def make(
    seed: int, folder: Path, *, kind: str | None = None, changed: Sequence[str] = ()
) -> Run:
    """Execute the run of a seed, with changed parameters; the room is written to a folder."""
    chance = Random(seed)
    drawn = "obstacles" if chance.random() < 0.3 else "plain"
    run = Run(seed, kind or drawn)
    obstacles = run.kind == "obstacles"
    system_profile = profile(OBSTACLES if obstacles else GOAL)
    room, start, goal = _scene(chance, obstacles=obstacles)
    file = folder / f"room{seed}"
    file.write_text(room, encoding="utf-8")
    settings = [
        *placed(start, "RefHw0" if obstacles else "RefHardRh30"),
        *(
            f"PositionInput0.{n}={v}"
            for n, v in zip(("01_x", "01_y", "01_th"), goal, strict=True)
        ),
        "PositionInput0.input=parameters",
        *changed,
    ]
    if obstacles:
        settings += [
            f"LRFCapture_URG0.room={file}",
            f"RefHw0.PlantRoom={file}",
            f"LRFCapture_URG0.noise={chance.uniform(0.0, 0.02):.4f}",
            f"LRFCapture_URG0.seed={seed % LONG}",
            "LRFCapture_URG0.resolution=0.03",
        ]
    links = AVOIDING if obstacles else PLAIN
    with build(system_profile, settings) as system:
        watch = _Watch(system, run, links)
        watch.furnish(parse(room, "room"))
        if obstacles:
            system.run(LOOK)
            system.deactivate("GamePad0")
        last = _plan(chance, system, system_profile, watch, run)
        _drive(system, watch, last)
        run.ended = at_end(system)
        _judge(run, system, watch, goal)
    return run


def _scene(chance: Random, *, obstacles: bool) -> tuple[str, Pose, Pose]:
    """Return the room, the start pose of the base, and its goal."""
    heading = lambda: round(chance.uniform(-pi, pi), 3)  # noqa: E731
    if not obstacles:
        there = [round(chance.uniform(-3.0, 3.0), 3) for _ in range(4)]
        return "", Pose(*there[:2], heading()), Pose(*there[2:], heading())
    start = Pose(
        0.0, round(chance.uniform(-1.0, 1.0), 3), round(chance.uniform(-1, 1), 3)
    )
    goal = Pose(
        round(chance.uniform(4.0, 7.0), 3), round(chance.uniform(-1, 1), 3), heading()
    )
    lines = ["w -2 -2 9 -2", "w -2 2 9 2", "w -2 -2 -2 2", "w 9 -2 9 2"]
    for _ in range(chance.randrange(4)):
        x, y = chance.uniform(1.5, 6.5), chance.uniform(-1.4, 1.4)
        radius = chance.uniform(0.1, 0.3)
        if hypot(x - goal.x, y - goal.y) > 0.8 + radius:
            lines.append(f"c {x:.3f} {y:.3f} {radius:.3f}")
    return "\n".join(lines) + "\n", start, goal


def _plan(
    chance: Random, system: System, file: model.System, watch: _Watch, run: Run
) -> int:
    """Schedule the accidents; return the end of the last one [ns]."""
    links = list(AVOIDING if run.kind == "obstacles" else PLAIN)
    spared = {"GamePad0", "ObstacleMonitor0"}
    instances = [name for name in system.instances if name not in spared]
    last = 0
    for _ in range(chance.randrange(4)):
        begin = round(chance.uniform(0.5, 15.0) * SECOND)
        # Short ones are as dangerous as long ones.
        end = begin + round(10 ** chance.uniform(-1.5, 0.7) * SECOND)
        what = chance.choice(("loss", "loss", "restart", "restart", "death"))
        if what == "loss":
            name = chance.choice(links)
            system.at(begin, lambda name=name: _cut(system, watch, name))
            system.at(end, lambda name=name: _join(system, file, watch, name))
            run.accidents.append(
                f"{begin / SECOND:.2f}-{end / SECOND:.2f} s without {name}"
            )
        else:
            one = chance.choice(instances)
            system.at(begin, lambda one=one: _off(system, one))
            if what == "restart":
                system.at(end, lambda one=one: _on(system, one))
            else:
                end = begin
            run.accidents.append(
                f"{begin / SECOND:.2f} s {what} of {one} until {end / SECOND:.2f}"
            )
        last = max(last, end)
    return last


def _cut(system: System, watch: _Watch, name: str) -> None:
    if name not in watch.cut:
        system.disconnect(name)
        watch.cut.add(name)


def _join(system: System, file: model.System, watch: _Watch, name: str) -> None:
    if name in watch.cut:
        [link] = [c for c in file.connections if c.name == name]
        source, target = link.source, link.target
        system.connect(
            (source.instance, source.port),
            (target.instance, target.port),
            dict(link.properties),
            name,
        )
        watch.cut.remove(name)


def _off(system: System, instance: str) -> None:
    if system.state(instance) is ACTIVE_STATE:
        system.deactivate(instance)


def _on(system: System, instance: str) -> None:
    if system.state(instance) is INACTIVE_STATE:
        system.activate(instance)


def _drive(system: System, watch: _Watch, last: int) -> None:
    """Run to the end, or until the base has stopped for good."""

    def over(running: System) -> bool:
        quiet = running.time - max(last, watch.still_since) > GIVEN_UP
        return at_end(running) or quiet

    system.run(MAX_DURATION, over)


def _judge(run: Run, system: System, watch: _Watch, goal: Pose) -> None:
    pose = Pose(*system.observable(f"{watch.base}.truth"))
    run.away = hypot(pose.x - goal.x, pose.y - goal.y)
    outcome = Outcome([], goal, [("base", pose)], 0.0, 0.0, (), Tolerance(NEAR, 0.1))
    run.missed = outcome.missed
    run.under_way = not run.ended and system.time >= MAX_DURATION
    for instance in system.instances:
        statistics = system.statistics(instance)
        word = statistics.reason or statistics.condition
        if statistics.reason.startswith("contact"):
            run.contact = statistics.reason
        if statistics.state is INACTIVE_STATE and instance != "GamePad0":
            word = "INACTIVE"
        if word and word != ALL_DONE:
            run.words.append(f"{instance}: {word}")


def main(arguments: list[str]) -> int:
    """Execute runs, and print their outcomes; return 1 if there was a violation."""
    parser = argparse.ArgumentParser(description="random runs of the navigation")
    parser.add_argument("runs", type=int)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("-v", "--verbose", action="store_true")
    options = parser.parse_args(arguments)
    runs = []
    with TemporaryDirectory() as folder:
        for seed in range(options.first, options.first + options.runs):
            run = make(seed, Path(folder))
            runs.append(run)
            if options.verbose or run.faults:
                print(
                    f"seed {seed} ({run.kind}): {run.became}, {run.away:.3f} m away",
                    flush=True,
                )
                for line in (*run.accidents, *run.words, *run.faults):
                    print(f"    {line}", flush=True)
    for (kind, became), count in sorted(
        Counter((r.kind, r.became) for r in runs).items()
    ):
        print(f"{count:5} {kind}: {became}")
    met = [run.away for run in runs if run.met]
    print(f"greatest distance of a goal that was met: {max(met, default=0.0):.3f} m")
    near = [run.least for run in runs if run.kind == "obstacles"]
    print(f"least room between body and anything: {min(near, default=0.0):.3f} m")
    bad = [run.seed for run in runs if run.faults]
    print(f"runs with a fault: {len(bad)} {bad or ''}".rstrip())
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
