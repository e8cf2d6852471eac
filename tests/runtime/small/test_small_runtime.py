"""The small runtime itself: life cycle, ports of fixed size, refusals of codecs."""

from __future__ import annotations

import pytest

from rtgen.small_runtime import (
    ACTIVE_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    PORT_OK,
    PRECONDITION_NOT_MET,
    RTC_OK,
    SECOND,
    CodecError,
    Component,
    InPort,
    Numbers,
    OutPort,
    PortStatus,
    SizeError,
    System,
    Values,
    Wire,
    bounded,
    copy_array,
    copy_items,
    exactly,
    from_cdr,
    to_cdr,
)


class Sample:
    """A hand-written equivalent of a generated struct of one number."""

    def __init__(self, value: int = 0) -> None:
        self.value = value

    def _copy_(self, other: Sample) -> None:
        self.value = other.value

    def _put_(self, wire: Wire) -> None:
        wire.put("<H", 2, self.value)

    def _take_(self, wire: Wire) -> None:
        self.value = wire.take("<H", 2)


class Probe(Component):
    """Records its callbacks, which behave as configured."""

    _type_name = "Probe"
    _rate = 10.0

    def __init__(self) -> None:
        super().__init__()
        self.calls: list[str] = []
        self.answers: dict[str, object] = {}

    def _does(self, name: str) -> int:
        self.calls.append(name)
        answer = self.answers.get(name, RTC_OK)
        if isinstance(answer, Exception):
            raise answer
        return answer  # type: ignore[return-value]

    def on_activated(self, ec_id: int) -> int:
        return self._does("on_activated")

    def on_deactivated(self, ec_id: int) -> int:
        return self._does("on_deactivated")

    def on_aborting(self, ec_id: int) -> int:
        return self._does("on_aborting")

    def on_error(self, ec_id: int) -> int:
        return self._does("on_error")

    def on_reset(self, ec_id: int) -> int:
        return self._does("on_reset")

    def on_execute(self, ec_id: int) -> int:
        return self._does("on_execute")

    def on_state_update(self, ec_id: int) -> int:
        return self._does("on_state_update")


@pytest.fixture
def probe() -> Probe:
    return Probe()


@pytest.fixture
def system(probe: Probe) -> System:
    system = System()
    system.add(probe)
    return system


def tick(system: System, times: int = 1) -> None:
    system.run(system.time + times * SECOND // 10)


def test_a_component_executes_while_it_is_active(system: System, probe: Probe) -> None:
    tick(system)
    assert (probe.calls, probe._state) == ([], INACTIVE_STATE)
    assert system.activate(probe) == RTC_OK
    tick(system)
    assert probe.calls == ["on_activated", "on_execute", "on_state_update"]
    assert probe._state == ACTIVE_STATE
    probe.calls.clear()
    assert system.deactivate(probe) == RTC_OK
    tick(system, 3)
    assert (probe.calls, probe._state) == (["on_deactivated"], INACTIVE_STATE)


@pytest.mark.parametrize("callback", ["on_activated", "on_execute", "on_state_update"])
@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (ValueError("no"), "{}: ValueError: no"),
        (ValueError(), "{}: ValueError"),
        (None, "{}: returned None"),
        (False, "{}: returned False"),
        (2, "{}: returned BAD_PARAMETER"),
        (99, "{}: returned 99"),
    ],
)
def test_a_failure_leads_to_error(
    system: System, probe: Probe, callback: str, answer: object, reason: str
) -> None:
    probe.answers[callback] = answer
    system.activate(probe)
    tick(system)
    assert probe.calls[-2:] == [callback, "on_aborting"]
    assert (probe._state, probe.reason) == (ERROR_STATE, reason.format(callback))
    probe.calls.clear()
    tick(system, 2)
    assert probe.calls == ["on_error", "on_error"]
    probe.answers["on_reset"] = 1
    assert system.reset(probe) == RTC_OK
    tick(system)
    assert probe._state == ERROR_STATE
    probe.answers.clear()
    system.reset(probe)
    tick(system)
    assert (probe._state, probe.reason) == (INACTIVE_STATE, "")


def test_a_reason_that_was_told_is_kept(system: System, probe: Probe) -> None:
    probe.on_execute = lambda ec_id: probe.fail("too hot")  # type: ignore[method-assign]
    system.activate(probe)
    tick(system)
    assert probe.reason == "too hot"


def test_requests_that_do_not_fit_are_refused(system: System, probe: Probe) -> None:
    assert system.deactivate(probe) == PRECONDITION_NOT_MET
    assert system.reset(probe) == PRECONDITION_NOT_MET
    for _ in range(9):
        assert system.activate(probe) == RTC_OK
    assert len(probe._requests) == 1
    tick(system)
    assert probe.calls.count("on_activated") == 1


def test_a_component_that_cannot_be_initialized_is_refused() -> None:
    class Broken(Component):
        def on_initialize(self) -> int:
            return self.fail("no device")

    with pytest.raises(ValueError, match="Component0: no device"):
        System().add(Broken())


def test_time_is_waited_for_where_there_is_a_clock(probe: Probe) -> None:
    waited: list[int] = []
    system = System(waited.append)
    system.add(probe, 2.0)
    system.run(SECOND)
    assert waited == [0, SECOND // 2]


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_refused(probe: Probe, rate: float) -> None:
    with pytest.raises(ValueError, match="Hz above 0"):
        System().add(probe, rate)


def test_parameters_are_set_by_text(system: System, probe: Probe) -> None:
    class Configuration:
        __slots__ = ("count", "gain", "name", "on")

    config = Configuration()
    config.count, config.gain, config.name, config.on = 1, 0.5, "", False
    probe.config = config  # type: ignore[attr-defined]
    for name, text in (("count", "7"), ("gain", "2"), ("name", "x"), ("on", "true")):
        system.configure(probe, name, text)
    assert (config.count, config.gain, config.name, config.on) == (7, 2.0, "x", True)
    for name, text in (("count", "a"), ("on", "yes"), ("other", "1")):
        with pytest.raises(ValueError, match=r"a|yes|other"):
            system.configure(probe, name, text)


def test_the_oldest_sample_is_overwritten() -> None:
    source = OutPort("out", Sample, "A0")
    target = InPort("in", Sample, "B0", 2)
    sample = Sample()
    assert source.write(sample) == PortStatus.PRECONDITION_NOT_MET
    source.connect(target)
    assert target.read() is None
    for sample.value in (1, 2, 3):
        assert source.write(sample) == PORT_OK
    assert (target.lost, source.unsent) == (1, 1)
    assert [target.read().value, target.read().value] == [2, 3]
    assert not target.is_new()
    assert target.read().value == 3
    assert target.read_newest() is None
    for sample.value in (4, 5):
        source.write(sample)
    assert target.read_newest().value == 5
    assert not target.is_new()


def test_ports_of_different_types_are_not_joined() -> None:
    source = OutPort("out", Sample, "A0")
    with pytest.raises(TypeError, match=r"A0.out sends Sample, B0.in takes Other"):
        source.connect(InPort("in", type("Other", (Sample,), {}), "B0", 1))


def test_ports_are_joined_once() -> None:
    source, target = OutPort("out", Sample, "A0"), InPort("in", Sample, "B0", 1)
    source.connect(target)
    with pytest.raises(ValueError, match=r"A0\.out is joined with B0\.in"):
        source.connect(target)


def test_numbers_keep_their_room() -> None:
    numbers = Numbers("h", 3)
    for value in (1, 2, 3):
        numbers.append(value)
    with pytest.raises(SizeError):
        numbers.append(4)
    numbers[-1] = 9
    assert [numbers[i] for i in range(len(numbers))] == [1, 2, 9]
    with pytest.raises(IndexError):
        numbers[3]
    with pytest.raises(SizeError):
        copy_items(numbers, [1, 2, 3, 4])
    with pytest.raises(SizeError):
        copy_array(Numbers("h", 2, 2), [1])
    fixed = Numbers("h", 2, 2)
    copy_array(fixed, [5, 6])
    assert [fixed[0], fixed[1]] == [5, 6]
    copy_items(fixed, fixed)
    assert len(fixed) == 2


def test_structs_are_filled_in_place() -> None:
    values = Values(Sample, 2)
    one = Sample(1)
    values.append(one)
    one.value = 2
    first = values[0]
    assert isinstance(first, Sample)
    assert first.value == 1
    values[0] = one
    assert values[0] is first
    assert first.value == 2
    values.next_free()
    for more in (values.next_free, lambda: values.append(one)):
        with pytest.raises(SizeError):
            more()
    values.clear()
    assert len(values) == 0


def test_texts_keep_their_room() -> None:
    texts = Values(None, 2, 0, 3)
    texts.append("abc")
    assert texts[0] == "abc"
    with pytest.raises(SizeError):
        texts.append("ああ")
    with pytest.raises(SizeError):
        texts[0] = "abcd"
    assert bounded("abc", 3) == "abc"
    assert exactly(b"ab", 2) == b"ab"
    with pytest.raises(SizeError):
        bounded("abcd", 3)
    with pytest.raises(SizeError):
        exactly(b"a", 2)


def test_octets_go_both_ways() -> None:
    buffer = bytearray(b"\xff" * 4)
    assert to_cdr(Sample(513), buffer) == 2
    assert buffer == b"\x01\x02\xff\xff"
    sample = Sample()
    from_cdr(sample, buffer, 2)
    assert sample.value == 513


@pytest.mark.parametrize("length", [1, 4])
def test_octets_of_another_length_are_refused(length: int) -> None:
    with pytest.raises(CodecError):
        from_cdr(Sample(), bytearray(4), length)


def test_what_does_not_fit_is_refused() -> None:
    with pytest.raises(CodecError):
        to_cdr(Sample(1), bytearray(1))
    with pytest.raises(CodecError):
        to_cdr(Sample(65536), bytearray(4))
    with pytest.raises(CodecError):
        Wire(bytearray(2)).put_octets(b"abc")
    with pytest.raises(CodecError):
        Wire(bytearray(9)).put_string("a\x00b")


@pytest.mark.parametrize(
    "octets",
    [
        b"",
        b"\x00\x00\x00\x00",
        b"\x02\x00\x00\x00aa",
        b"\x02\x00\x00\x00\xff\x00",
        b"\x03\x00\x00\x00\x00a\x00",
        b"\x09\x00\x00\x00abcdefgh\x00",
        b"\xff\xff\xff\xffabc\x00",
    ],
)
def test_strings_that_are_none(octets: bytes) -> None:
    with pytest.raises(CodecError):
        Wire(bytearray(octets)).take_string(4)


def test_booleans_and_padding() -> None:
    wire = Wire(bytearray(b"\xff" * 8))
    wire.put("<B", 1, 1)
    wire.put("<I", 4, 7)
    assert wire.buffer == b"\x01\x00\x00\x00\x07\x00\x00\x00"
    assert Wire(bytearray(b"\x01")).take_boolean() is True
    with pytest.raises(CodecError):
        Wire(bytearray(b"\x02")).take_boolean()


def test_samples_execute_event_driven_components_as_on_the_embedded_runtime() -> None:
    """In any order of `add`, at the instant of the sample; what waited, at the activation."""

    class Part(Component):
        _triggers = ("in",)

        def __init__(self, name: str, passed: list[tuple[str, int, int]]) -> None:
            super().__init__(name)
            self.passed = passed
            self.input = self.add_in_port("in", Sample)
            self.aside = self.add_in_port("aside", Sample)
            self.output = self.add_out_port("out", Sample)

        def on_execute(self, ec_id: int) -> int:
            sample = self.input.read()
            self.passed.append((self.instance_name, self.now(), sample.value))
            self.output.write(sample)
            return RTC_OK

    class Source(Component):
        _rate = 100.0

        def __init__(self) -> None:
            super().__init__("source")
            self.count = 0
            self.output = self.add_out_port("out", Sample)

        def on_execute(self, ec_id: int) -> int:
            for _ in range(2):
                self.output.write(Sample(self.count))
                self.count += 1
            return RTC_OK

    system, passed = System(), []
    parts, source = [Part(name, passed) for name in "ab"], Source()
    for component in (parts[1], source, parts[0]):
        system.add(component, 100.0)
        system.activate(component)
    source.output.connect(parts[0].input)
    source.output.connect(parts[1].aside)
    parts[0].output.connect(parts[1].input)
    system.run(20_000_000)
    assert [(name, value) for name, time, value in passed if time == 10_000_000] == [
        *(("a", 2), ("b", 2), ("a", 3), ("b", 3))
    ]
    assert [name for name, time, _ in passed if time == 0] == [*"abab"]
    assert system.ticks(parts[1]) == 4
