"""The joint experiments: any joystick and any robot, followers, exchange of leaders."""

from __future__ import annotations

import re
from functools import cache
from itertools import pairwise
from math import dist, hypot, inf
from pathlib import Path

import pytest
from experiments import EXPERIMENTS, Experiment, perform

from rtgen.cli import run as rtgen
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.systems.measures import Pose
from rtgen.runtime import ACTIVE_STATE, INACTIVE_STATE

JOYSTICKS = ("JoystickA0", "JoystickB0", "SegwayJoystick0", "AistJoystick0")
ROBOTS = ("RefHard0", "OmniWheel0", "SegwayRmp0", "BlackShip0")
SHORT = ("interchange", "two_robots", "chain", "phases")


@cache
def first_run(name: str) -> Experiment:
    """Return an experiment that many tests use."""
    return perform(EXPERIMENTS / name)


@pytest.fixture
def leaders_and_all() -> Experiment:
    """B1, and B2 after it: one run."""
    return first_run("one_to_four")


@pytest.fixture
def chain() -> Experiment:
    """Return Ref-Hard, followed by Segway RMP, followed by Omni-Wheel."""
    return first_run("chain")


def kept(run: Experiment) -> dict[str, bool]:
    """Return every measure with its time, and whether its limits were kept."""
    return {
        f"{result.measure.name} {result.measure.begin}": result.kept
        for result in run.results
    }


def nearest(here: Pose, track: list[Pose]) -> float:
    """Return the distance to the nearest of many points."""
    return min((dist(here[:2], there[:2]) for there in track), default=inf)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", SHORT)
def test_what_an_experiment_measures_is_as_it_should_be(name: str) -> None:
    run = first_run(name)
    assert run.results
    assert [name for name, fine in kept(run).items() if not fine] == []
    assert all(run.system.statistics(i).lost == 0 for i in run.system.instances)


def test_every_joystick_drives_every_robot() -> None:
    run = first_run("interchange")
    pairs = {tuple(result.measure.name.split(" drives ")) for result in run.results}
    assert pairs == {(j, r) for j in JOYSTICKS for r in ROBOTS}
    assert len(run.results) == 16
    assert all(result.kept for result in run.results)
    # Each robot has driven: 1.2 m and two arcs in every round.
    for result in run.results:
        begin = result.measure.begin
        poses = run.poses(
            result.measure.of.partition(".")[0], begin, result.measure.end
        )
        way = sum(dist(a[:2], b[:2]) for a, b in pairwise(poses))
        assert way == pytest.approx(0.3 * 10.0, abs=0.05)


def test_two_robots_move_alike_over_18_steps() -> None:
    run = first_run("two_robots")
    one, other = (
        [(x - p[0][0], y - p[0][1]) for x, y, _ in p]
        for p in (run.poses("RefHard0", 0, 20), run.poses("OmniWheel0", 0, 20))
    )
    # The 18 photographs: at the end of each step of a second, the first from 1 s on.
    steps = [(1 + step) * 50 for step in range(1, 19)]
    assert max(dist(one[i], other[i]) for i in steps) < 0.02
    assert dist(one[steps[-1]], (0.0, 0.0)) > 2.0
    # Straight, then to the left, then to the right.
    headings = [pose[2] for pose in run.poses("RefHard0", 0, 20)]
    straight, left, right = (headings[steps[i]] for i in (5, 11, 17))
    assert straight == pytest.approx(0.0, abs=0.01)
    assert left == pytest.approx(2.4, abs=0.05)
    assert right == pytest.approx(0.0, abs=0.05)


@pytest.mark.sampled(0)
def test_the_follower_of_a_track_stays_on_it(chain: Experiment) -> None:
    track = chain.poses("RefHard0", 0.0, 75.0)
    follower = chain.poses("SegwayRmp0", 9.0, 75.0)
    assert max(nearest(pose, track) for pose in follower[::25]) < 0.3
    assert dist(follower[0][:2], follower[-1][:2]) > 2.0


@pytest.mark.sampled(0)
def test_the_follower_of_a_robot_keeps_its_distance(chain: Experiment) -> None:
    gaps = [
        dist(one[:2], other[:2])
        for one, other in zip(
            chain.poses("SegwayRmp0", 0.0, 75.0),
            chain.poses("OmniWheel0", 0.0, 75.0),
            strict=True,
        )
    ]
    assert min(gaps) >= 0.8
    assert max(gaps) <= 1.5


@pytest.mark.sampled(0)
def test_the_chain_stays_within_its_area(chain: Experiment) -> None:
    for instance in ("RefHard0", "SegwayRmp0", "OmniWheel0"):
        for x, y, _ in chain.poses(instance, 0.0, 75.0):
            assert 0.0 <= x <= 6.0
            assert 0.0 <= y <= 7.0


@pytest.mark.sampled(0)
def test_both_ways_of_following_are_used(chain: Experiment) -> None:
    ways = {
        name: chain.components[name].configuration_sets.texts()["following"]
        for name in ("SegwayRmp0", "OmniWheel0")
    }
    assert ways == {"SegwayRmp0": "track", "OmniWheel0": "distance"}


@pytest.mark.sampled(0)
def test_leaders_are_exchanged_twice_and_one_joystick_drives_all(
    leaders_and_all: Experiment,
) -> None:
    failed = [name for name, fine in kept(leaders_and_all).items() if not fine]
    assert failed == []
    names = " ".join(kept(leaders_and_all))
    for robot in ROBOTS:
        assert f"{robot} stands by" in names


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("leader", "rewired", "until"),
    [("SegwayRmp0", 48.0, 139.0), ("OmniWheel0", 141.0, 174.0)],
)
def test_ten_seconds_after_an_exchange_the_track_of_the_new_leader_is_followed(
    leaders_and_all: Experiment, leader: str, rewired: float, until: float
) -> None:
    track = leaders_and_all.poses(leader, rewired, until)
    follower = leaders_and_all.poses("RefHard0", rewired + 10.0, until)
    assert max(nearest(pose, track) for pose in follower[::25]) < 0.3


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("leader", "rewired", "until"),
    [("OmniWheel0", 48.0, 139.0), ("SegwayRmp0", 141.0, 174.0)],
)
def test_ten_seconds_after_an_exchange_the_distance_to_the_new_leader_is_kept(
    leaders_and_all: Experiment, leader: str, rewired: float, until: float
) -> None:
    ahead = leaders_and_all.poses(leader, rewired + 10.0, until)
    follower = leaders_and_all.poses("BlackShip0", rewired + 10.0, until)
    errors = [
        abs(dist(a[:2], b[:2]) - 1.0) for a, b in zip(ahead, follower, strict=True)
    ]
    assert max(errors) < 0.3
    assert hypot(follower[-1][0] - follower[0][0], follower[-1][1] - follower[0][1]) > 1


@pytest.mark.sampled(0)
def test_the_same_objects_run_through_b1_and_b2(leaders_and_all: Experiment) -> None:
    run = leaders_and_all
    assert run.system.time == 420 * 10**9
    for name, component in run.components.items():
        assert run.system.component(name) is component
        changes = [(s.before, s.after) for s in run.states if s.instance == name]
        # Activated once, at the beginning, and nothing else.
        assert changes == [(INACTIVE_STATE, ACTIVE_STATE)]
        period = run.system.context(name).period
        assert run.system.statistics(name).ticks == 420 * 10**9 // period


def test_b2_has_the_system_of_b1() -> None:
    texts = [
        (EXPERIMENTS / name / "system.xml").read_text(encoding="utf-8")
        for name in ("leader_exchange", "one_to_four")
    ]
    one, other = (
        text[text.index("<rts:Components") : text.index("rtgen.run.until")]
        for text in texts
    )
    assert one == other


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    "name", [*SHORT, pytest.param("one_to_four", marks=pytest.mark.nightly)]
)
def test_an_experiment_repeats_bit_for_bit(name: str) -> None:
    first = first_run(name)
    second = perform(EXPERIMENTS / name)
    assert first.digest == second.digest
    assert first.course == second.course


def test_a_joystick_of_phase_1_does_not_fit_a_robot_of_phase_3() -> None:
    with pytest.raises(InputError) as refused:
        perform(EXPERIMENTS / "phases", "refused.toml")
    [finding] = refused.value.diagnostics
    assert "RTC::TimedVelocity  IDL:RTC/TimedVelocity:1.0" in finding.message
    assert "IIS::TimedVelocity2D  IDL:IIS/TimedVelocity2D:1.0" in finding.message
    assert "double va" in finding.message
    assert finding.span is not None
    assert finding.span.line == 5


def test_an_adapter_joins_them() -> None:
    run = first_run("phases")
    assert [name for name, fine in kept(run).items() if not fine] == []
    before, *_, after = run.poses("TravelControl0", 0.0, 10.0)
    assert dist(before[:2], after[:2]) == pytest.approx(0.8, abs=0.05)
    assert type(run.components["VelocityAdapter0"]).__module__ == (
        "refrobots.adapters.velocity_adapter"
    )


def test_a_run_prints_its_results_and_writes_picture_and_csv(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfdbinary: pytest.CaptureFixture[bytes],
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert rtgen(["run", str(EXPERIMENTS / "two_robots")]) == 0
    out, err = (text.decode() for text in capfdbinary.readouterr())
    assert "results: build/two_robots/two_robots.csv" in err
    row = r"RefHard0 and OmniWheel0 alike +0 +end +0\.000 +0\.0\d\d +0 \.\. 0\.02 +yes"
    assert re.search(row, out)
    table = (tmp_path / "build/two_robots/two_robots.csv").read_text().splitlines()
    assert table[0] == "t,robot,x,y,theta"
    assert len(table) == 1 + 2 * 20 * 50
    picture = (tmp_path / "build/two_robots/two_robots.svg").read_text()
    assert picture.startswith("<?xml")


def test_a_run_with_a_limit_that_is_not_kept_ends_with_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    slow = ["--set", "OmniWheel0.max_wheel_acceleration=1"]
    assert rtgen(["run", "-q", str(EXPERIMENTS / "two_robots"), *slow]) == 1
