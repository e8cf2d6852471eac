"""Readers for repeated shapes: the same values, the same refusals, in a limited number."""

import emitted
import pytest

from refrobots import iis, rtc
from rtgen.facts.numeric import MAX_LIST_LENGTH
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.compiler import compiled_in_python
from rtgen.runtime.marshalling.source import repeated


@pytest.fixture
def decode():
    """Return a decoder of TimedPose2D without readers."""
    descriptor = iis.TimedPose2D._descriptor_
    kept = dict(descriptor.codecs)
    descriptor.codecs.clear()
    yield compiled_in_python("from_cdr", descriptor)
    descriptor.codecs.update(kept)


def pose(ids: int, errors: int, start: int = 0) -> iis.TimedPose2D:
    """Return a value with these numbers of ids and errors."""
    return iis.TimedPose2D(
        rtc.Time(start + 1, 2),
        [start + n for n in range(ids)],
        rtc.Pose2D(rtc.Point2D(1.5, -2.0), start / 7),
        [start - n / 3 for n in range(errors)],
    )


def readers(function, little_endian: bool):
    """Return the readers of a function, by size."""
    order = "little" if little_endian else "big"
    return function.__globals__[f"repeated_{order}"]


def learn(function, value, little_endian: bool) -> None:
    """Decode bodies of the shape until there is a reader for it."""
    octets = value.to_cdr(little_endian)
    for _ in range(repeated.SIGHTINGS):
        assert len(octets) not in readers(function, little_endian)
        assert function(type(value), octets, little_endian) == value
    reader = readers(function, little_endian)[len(octets)]
    assert reader(type(value), octets) == value
    assert reader.__code__.co_filename.startswith("<CDR from_cdr of IIS::TimedPose2D, ")


@pytest.mark.parametrize("little_endian", [True, False])
@pytest.mark.parametrize(("ids", "errors"), [(0, 0), (1, 3), (2, 0), (7, 9)])
def test_a_shape_that_repeats_gives_the_same_values(decode, little_endian, ids, errors):
    learn(decode, pose(ids, errors), little_endian)
    for start in range(5):
        value = pose(ids, errors, start)
        octets = value.to_cdr(little_endian)
        for source in (octets, bytearray(octets), memoryview(octets)):
            assert decode(iis.TimedPose2D, source, little_endian) == value


def test_another_shape_of_the_same_size_is_read_as_before(decode):
    assert len(pose(0, 3).to_cdr()) == len(pose(1, 3).to_cdr())
    learn(decode, pose(0, 3), True)
    for ids in (1, 0, 1):
        value = pose(ids, 3, 4)
        assert decode(iis.TimedPose2D, value.to_cdr()) == value


def test_each_fault_is_found_as_without_a_reader(decode):
    octets = pose(1, 3).to_cdr()
    broken = [octets[:n] for n in range(len(octets))] + [octets + b"\0"]
    broken += [octets[:8] + bytes([n]) + octets[9:] for n in (0, 2, 3, 40, 200, 255)]
    broken += [octets[:40] + bytes([n]) + octets[41:] for n in (0, 1, 4, 200, 255)]
    before = [outcome(decode, each) for each in broken]
    learn(decode, pose(1, 3), True)
    assert [outcome(decode, each) for each in broken] == before
    assert any("TimedPose2D.error" in str(each) for each in before)


def outcome(function, octets):
    """Return the value, or the text of the CdrError."""
    try:
        return function(iis.TimedPose2D, octets)
    except CdrError as error:
        return str(error)


def test_readers_are_bounded(decode):
    for errors in range(2 * repeated.READERS_KEPT):
        octets = pose(0, errors).to_cdr()
        for _ in range(repeated.SIGHTINGS):
            decode(iis.TimedPose2D, octets)
    assert len(readers(decode, True)) == repeated.READERS_KEPT
    assert decode.__globals__["watching"] == []


def test_a_long_shape_gets_no_reader_and_is_not_watched_for_ever(decode):
    octets = pose(0, MAX_LIST_LENGTH + 1).to_cdr()
    for _ in range(repeated.WATCHED):
        assert decode.__globals__["watching"]
        decode(iis.TimedPose2D, octets)
    assert not readers(decode, True)
    assert decode.__globals__["watching"] == []


def test_arrays_of_records_beside_a_sequence(tmp_path):
    text = """module M {
        struct Point { double x; octet mark; };
        struct Scan { sequence<long> ids; char grid[2][2]; Point ends[2]; };
    };"""
    m = emitted.emit_text(tmp_path, text).m
    scan = m.Scan([1, 2], ["ab", "cd"], [m.Point(0.5, 1), m.Point(-0.5, 2)])
    for little_endian in (True, False):
        for _ in range(repeated.SIGHTINGS + 2):
            assert m.Scan.from_cdr(scan.to_cdr(little_endian), little_endian) == scan
