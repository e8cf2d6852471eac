"""Arrays that reuse memory: a decoded array keeps its numbers while anything refers to it."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import weakref
from array import array
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from types import FrameType
from typing import Any

import emitted
import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.runtime.marshalling import last_arrays
from rtgen.runtime.marshalling.last_arrays import LastArrays
from rtgen.runtime.marshalling.numeric import NumericArray

IDL = "module kept { struct Scan { sequence<double> ranges; }; };"
COUNT = 2_500
"""From this length on, numpy swaps numbers into the memory of earlier arrays."""

HOLDERS: dict[str, Callable[[Any], Any]] = {
    "struct": lambda scan: scan,
    "array": lambda scan: scan.ranges,
    "view": lambda scan: memoryview(scan.ranges),
    "part of a view": lambda scan: memoryview(scan.ranges)[7:],
    "numpy array": lambda scan: numpy.frombuffer(scan.ranges),
    "weak reference": lambda scan: weakref.ref(scan.ranges),
    "iterator": lambda scan: iter(scan.ranges),
}


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit_text(tmp_path_factory.mktemp("kept"), IDL, "array").kept.Scan


def octets(scan: Any, number: float, count: int, little: bool) -> bytes:
    return scan(array("d", [number]) * count).to_cdr(little)


def numbers(held: Any) -> set[float]:
    """Return the different numbers that a holder shows; an iterator is used up."""
    if isinstance(held, weakref.ref):
        held = held() or ()
    return set(getattr(held, "ranges", held))


_STEPS = st.tuples(
    st.sampled_from([*HOLDERS, "nothing"]),
    st.sampled_from([COUNT, COUNT + 1]),
    st.integers(0, 8),
)


@pytest.mark.sampled(0)
@given(st.lists(_STEPS, min_size=5, max_size=30), st.booleans())
def test_what_refers_to_an_array_keeps_its_numbers(
    scan: Any, steps: list[tuple[str, int, int]], little: bool
) -> None:
    held: list[tuple[float, Any]] = []
    for number, (holder, count, kept) in enumerate(steps):
        value = scan.from_cdr(octets(scan, number, count, little), little)
        assert set(value.ranges) == {number}
        assert len(value.ranges) == count
        if holder != "nothing":
            held.append((number, HOLDERS[holder](value)))
        del value
        for known, old in held[: max(0, len(held) - kept)]:
            assert numbers(old) <= {known}
        del held[: max(0, len(held) - kept)]
    for known, old in held:
        assert numbers(old) <= {known}


@pytest.fixture
def frequent_switches() -> Iterator[None]:
    """Switch between threads as often as possible."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.sampled(1)
@pytest.mark.usefixtures("frequent_switches")
@pytest.mark.parametrize("little", [False, True])
def test_threads_get_arrays_of_their_own(scan: Any, little: bool) -> None:
    def decode(number: int) -> list[set[float]]:
        data = octets(scan, number, COUNT, little)
        last = scan([])
        seen: list[set[float]] = []
        for _ in range(300):
            value = scan.from_cdr(data, little)
            seen += (set(value.ranges), set(last.ranges))
            last = value
        return seen

    with ThreadPoolExecutor(8) as threads:
        for number, seen in enumerate(threads.map(decode, range(8))):
            assert seen[1] == set()
            assert all(each == {number} for each in (seen[0], *seen[2:]))


def test_only_the_oldest_unused_array_that_fits_is_returned() -> None:
    last: LastArrays[array[Any]] = LastArrays()
    assert last.unused("d", 3) is None

    def keep(*sizes: int) -> list[int]:
        made = [array("d", range(size)) for size in sizes]
        for each in made:
            last.keep(each)
        return [id(each) for each in made]

    first, *_, fourth = keep(3, 3, 3, 3)
    assert id(last.unused("d", 3)) == first
    last.keep(array("d", range(2)))
    assert last.unused("f", 3) is None
    assert last.unused("d", 2) is None, "fewer than four arrays are left"
    keep(3, 3)
    assert id(last.unused("d", 3)) == fourth
    keep((1 << 18) + 1)
    assert last.unused("d", 2) is None, "an array of more than 2 MiB is not kept"


def test_a_signal_handler_may_refer_to_the_array_at_any_step() -> None:
    """It replaces the weak reference to the oldest array by a reference."""
    kept: LastArrays[NumericArray[float]] = LastArrays()
    weak: list[weakref.ref[NumericArray[float]]] = []
    strong: list[NumericArray[float] | None] = []
    steps = 0

    def trace(frame: FrameType, event: str, argument: object) -> Any:
        nonlocal steps
        frame.f_trace_opcodes = True
        steps -= 1
        if not steps:
            strong.append(weak.pop()())
        return trace

    before = sys.gettrace()
    for stop in range(1, 100):
        for number in range(4):
            made = NumericArray("d", [number])
            kept.keep(made)
            if not number:
                weak.append(weakref.ref(made))
        del made
        steps = stop
        sys.settrace(trace)
        unused = kept.unused("d", 1)
        sys.settrace(before)
        if weak:
            break
        assert strong
        assert unused is None or unused is not strong.pop()
        strong.clear()
    else:
        pytest.fail("`unused` takes more steps than the test")
    assert stop > 20


def test_a_tracer_does_not_change_the_number_of_references() -> None:
    def trace(frame: FrameType, event: str, argument: object) -> Any:
        return trace if frame.f_locals is not None else None

    spec = importlib.util.spec_from_file_location("traced", last_arrays.__file__)
    assert spec is not None
    assert spec.loader is not None
    traced = importlib.util.module_from_spec(spec)
    before = sys.gettrace()
    sys.settrace(trace)
    spec.loader.exec_module(traced)
    sys.settrace(before)
    last = traced.LastArrays()
    made = [array("d", [number]) for number in range(4)]
    for each in made:
        last.keep(each)
    assert last.unused("d", 1) is None


IMPORTING = """
import sys, threading
from array import array
from refrobots.rtc import Time, TimedDoubleSeq
assert "numpy" not in sys.modules
value = TimedDoubleSeq(Time(1, 2), array("d", [1.5]) * 3000)
octets = value.to_cdr(False)
thread = threading.Thread(target=__import__, args=("numpy",))
thread.start()
while thread.is_alive():
    assert TimedDoubleSeq.from_cdr(octets, False) == value
    assert value.to_cdr(False) == octets
"""


def test_numbers_are_swapped_while_a_thread_imports_numpy() -> None:
    subprocess.run([sys.executable, "-c", IMPORTING], check=True)
