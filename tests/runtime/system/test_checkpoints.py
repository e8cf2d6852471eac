"""Checkpoints: the stored state of a component whose process dies, and when it is ignored."""

from __future__ import annotations

from pathlib import Path

import pytest

from refrobots import checkpoints, rtc
from rtgen.runtime import (
    RTC_OK,
    Checkpoint,
    CheckpointError,
    CheckpointFolder,
    Component,
    ReturnCode_t,
    SimulatedClock,
    System,
)
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.rtc.checkpoints import MAX_LENGTH

State = checkpoints.Goals


class Keeper(Component):
    """A component that stores a value, and restores it on activation."""

    def on_initialize(self) -> ReturnCode_t:
        self.kept = self.add_checkpoint(State)
        self.found: list[State | None] = []
        return RTC_OK

    def on_activated(self, ec_id: int) -> ReturnCode_t:
        self.found.append(self.kept.restored())
        return RTC_OK


def pose(x: float) -> rtc.Pose2D:
    return rtc.Pose2D(rtc.Point2D(x, 0.0), 0.0)


def state(*places: float) -> State:
    return State([pose(x) for x in places], [])


def opened(folder: Path, type_: type = State) -> Checkpoint[State]:
    """Return the checkpoint of K0 in a process that has just been started."""
    made = Checkpoint(type_, "K0")
    made.open(CheckpointFolder(folder).file("K0"))
    return made


def test_a_component_finds_its_state_at_its_first_activation(tmp_path: Path) -> None:
    for begin in (None, state(1.0)):
        keeper = Keeper("a/b 0")
        with System(SimulatedClock(), checkpoints=CheckpointFolder(tmp_path)) as system:
            system.add(keeper, 10.0)
            for _ in range(2):
                system.activate("a/b 0")
                system.run(system.time + 200_000_000)
                system.deactivate("a/b 0")
                system.run(system.time + 200_000_000)
            assert keeper.found == [begin, None]
            assert keeper.kept.is_kept
            keeper.kept.save(state(1.0))
        assert not keeper.kept.is_kept
        keeper.kept.save(state(2.0))
    assert [file.name for file in tmp_path.iterdir()] == ["a%2Fb%200.checkpoint"]


def test_without_a_folder_nothing_is_kept() -> None:
    with System(SimulatedClock()) as system:
        keeper = Keeper("K0")
        system.add(keeper, 10.0)
        keeper.kept.save(state(1.0))
        system.activate("K0")
        system.run(200_000_000)
        assert keeper.found == [None]


def test_the_newest_state_counts(tmp_path: Path) -> None:
    for number in range(5):
        kept = opened(tmp_path)
        assert kept.restored() == (state(float(number - 1)) if number else None)
        assert kept.restored() is None
        kept.save(state(7.0, 8.0, 9.0))
        kept.save(state(float(number)))


@pytest.mark.parametrize("writes", [1, 2, 3])
def test_a_write_that_was_cut_short_leaves_the_state_before(
    tmp_path: Path, writes: int
) -> None:
    kept = opened(tmp_path)
    for number in range(writes):
        kept.save(state(float(number)))
    [file] = tmp_path.iterdir()
    before = file.read_bytes()
    kept.save(state(99.0))
    after = file.read_bytes()
    changed = [
        i for i, pair in enumerate(zip(before, after, strict=True)) if len({*pair}) > 1
    ]
    # Cut at each octet that differs; after the last one the write was complete.
    for end in changed:
        file.write_bytes(after[:end] + before[end:])
        assert opened(tmp_path).restored() == state(float(writes - 1))
    file.write_bytes(after[: changed[-1] + 1] + before[changed[-1] + 1 :])
    assert opened(tmp_path).restored() == state(99.0)


def test_a_state_of_another_definition_is_not_used(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    opened(tmp_path).save(state(1.0))
    assert opened(tmp_path, checkpoints.Base).restored() is None
    assert "K0: its checkpoint is not used: it is of another definition" in caplog.text


@pytest.mark.parametrize("octets", [b"", b"x" * 7, b"\xff" * 3 * MAX_LENGTH])
def test_a_file_that_is_none_begins_anew(tmp_path: Path, octets: bytes) -> None:
    (tmp_path / "K0.checkpoint").write_bytes(octets)
    kept = opened(tmp_path)
    assert kept.restored() is None
    kept.save(state(1.0))
    assert opened(tmp_path).restored() == state(1.0)


def test_what_cannot_be_kept(tmp_path: Path) -> None:
    kept = opened(tmp_path)
    kept.save(state(1.0))
    with pytest.raises(CheckpointError, match="65536 octets at most, not 72012"):
        kept.save(state(*[0.0] * 3000))
    with pytest.raises(CdrError):
        kept.save(State(["no pose"], []))  # type: ignore[list-item]
    assert opened(tmp_path).restored() == state(1.0)
    keeper = Keeper("K0")
    keeper.on_initialize()
    with pytest.raises(CheckpointError, match="K0 has a checkpoint already"):
        keeper.add_checkpoint(State)


def test_a_folder_that_cannot_be_used(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(CheckpointError, match="file: "):
        CheckpointFolder(file)
    (tmp_path / "K0.checkpoint").mkdir()
    keeper = Keeper("K0")
    system = System(SimulatedClock(), checkpoints=CheckpointFolder(tmp_path))
    with pytest.raises(CheckpointError, match=r"K0\.checkpoint: "):
        system.add(keeper)
    assert not keeper.is_alive()
    assert system.instances == ()
