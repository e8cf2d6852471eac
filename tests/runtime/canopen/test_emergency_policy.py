"""Emergencies that stop a proxy, those that are only reported, and recovery from ERROR."""

from __future__ import annotations

import logging

import pytest
from proxy_bench import MS, NODE, Bench

from rtgen.runtime.canopen.wire.emergency import (
    DEFAULT_STOPS,
    Emergency,
    EmergencyPolicy,
    ErrorRegister,
)
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState


def emergency(code: int) -> Emergency:
    return Emergency(code, ErrorRegister.GENERIC)


@pytest.mark.parametrize(
    ("patterns", "stopping", "reported"),
    [
        (
            DEFAULT_STOPS,
            (0x1000, 0x2310, 0x5000, 0x6200, 0x8130, 0x8150, 0x8611, 0x9000, 0xFF01),
            (0x0000, 0x8110, 0x8120, 0x8140, 0x8210, 0x8220, 0x8240, 0x8250),
        ),
        ("2xxx, 3xxx", (0x2310, 0x3000), (0x1000, 0x4210, 0x8130)),
        ("xxxx,-23xx,2311", (0x2311, 0x2200), (0x2310, 0x23FF)),
        ("-xxxx", (), (0x1000, 0xFFFF)),
        ("ff0a", (0xFF0A,), (0xFF0B,)),
    ],
)
def test_the_last_pattern_that_matches_decides(
    patterns: str, stopping: tuple[int, ...], reported: tuple[int, ...]
) -> None:
    policy = EmergencyPolicy(patterns)
    assert all(policy.stops(emergency(code)) for code in stopping)
    assert not any(policy.stops(emergency(code)) for code in reported)


@pytest.mark.parametrize("patterns", ["", "82x", "0x8210", "xxxx,", "gggg", "--82xx"])
def test_what_is_no_pattern(patterns: str) -> None:
    with pytest.raises(ValueError, match="is not a pattern of emergency codes"):
        EmergencyPolicy(patterns)


def active(**settings: object) -> Bench:
    bench = Bench(settings=settings)
    bench.with_node()
    bench.run(0.05)
    bench.activate()
    return bench


def test_a_message_about_a_frame_is_reported_once_and_the_work_goes_on(
    caplog: pytest.LogCaptureFixture,
) -> None:
    message = "node 5 reports EMCY 8210h PDO too short (generic)"
    with active() as bench, caplog.at_level(logging.WARNING):
        for _ in range(3):
            bench.node.send(emergency(0x8210).frame(NODE))
        bench.run(0.1)
        assert bench.state == "ACTIVE"
        assert bench.reason == message
        assert caplog.messages == [f"Drive0: {message}"]
        bench.node.send(emergency(0).frame(NODE))
        bench.node.send(emergency(0x8210).frame(NODE))
        bench.run(0.1)
        assert caplog.messages == [f"Drive0: {message}"] * 2


def test_a_storm_of_reports_is_bounded(caplog: pytest.LogCaptureFixture) -> None:
    with active(emergency_stop="-xxxx") as bench, caplog.at_level(logging.WARNING):
        for code in range(0x8200, 0x9200):
            bench.node.send(emergency(code).frame(NODE))
        bench.run(0.1)
        assert bench.state == "ACTIVE"
        assert len(caplog.messages) == 16


def test_the_parameter_decides() -> None:
    with active(emergency_stop="82xx") as bench:
        bench.node.send(emergency(0x2310).frame(NODE))
        bench.run(0.1)
        assert bench.state == "ACTIVE"
        bench.node.send(emergency(0x8210).frame(NODE))
        bench.until("ERROR")


def test_a_parameter_that_is_no_list_of_patterns() -> None:
    with Bench(settings={"emergency_stop": "all"}) as bench:
        bench.with_node()
        bench.system.activate("Drive0")
        bench.until("ERROR")
        assert bench.reason == (
            "emergency_stop: 'all' is not a pattern of emergency codes, such as 23xx or -82xx"
        )


# Recovery


def resets(bench: Bench) -> int:
    return bench.commands().count((NmtCommand.RESET_NODE, NODE))


def test_without_the_option_it_waits_for_a_hand() -> None:
    with active() as bench:
        bench.node.send(emergency(0x2310).frame(NODE))
        bench.until("ERROR")
        bench.run(60)
        assert (bench.state, resets(bench)) == ("ERROR", 0)


def test_it_recovers_by_itself_and_is_active_again() -> None:
    with active(recoveries=2) as bench:
        bench.node.send(emergency(0x2310).frame(NODE))
        bench.until("ERROR")
        failed = bench.system.time
        bench.run(0.9)
        assert (bench.state, resets(bench)) == ("ERROR", 0), "it stands still first"
        bench.until("ACTIVE")
        assert 1000 * MS <= bench.system.time - failed <= 1200 * MS
        assert (bench.node.state, resets(bench)) == (NmtState.OPERATIONAL, 1)
        assert bench.reason == ""


def test_attempts_in_a_row_are_bounded_and_count_anew_after_work() -> None:
    with active(recoveries=2) as bench:
        for attempt in (1, 2):
            bench.node.send(emergency(0x2310).frame(NODE))
            bench.until("ERROR")
            bench.until("ACTIVE")
            assert resets(bench) == attempt
        bench.run(11)
        bench.node.send(emergency(0x2310).frame(NODE))
        bench.until("ERROR")
        bench.until("ACTIVE")
        for _ in range(2):
            bench.node.send(emergency(0x2310).frame(NODE))
            bench.until("ERROR")
            bench.run(5)
        assert (bench.state, resets(bench)) == ("ERROR", 4)


def test_a_node_that_stays_away_is_tried_so_often() -> None:
    with active(recoveries=3, boot_timeout=500) as bench:
        bench.node.obeys = False
        bench.node.mute()
        bench.until("ERROR")
        bench.run(60)
        assert (bench.state, resets(bench)) == ("ERROR", 3)
        assert bench.reason == "node 5: no boot-up message within 0.5 s"


def test_the_pause_begins_when_the_bus_is_back() -> None:
    with active(recoveries=1) as bench:
        bench.bus.cut()
        bench.until("ERROR")
        bench.run(30)
        assert (bench.state, resets(bench)) == ("ERROR", 0)
        bench.bus.mend()
        bench.until("ACTIVE")
        assert resets(bench) == 1


def test_one_that_was_never_active_stays_inactive() -> None:
    with Bench(settings={"recoveries": 1}) as bench:
        bench.with_node()
        bench.run(0.1)
        bench.node.send(emergency(0x2310).frame(NODE))
        bench.until("ERROR")
        bench.until("INACTIVE")
        bench.run(10)
        assert bench.state == "INACTIVE"


def test_a_reset_by_hand_does_not_activate() -> None:
    with active(recoveries=1) as bench:
        bench.node.send(emergency(0x2310).frame(NODE))
        bench.until("ERROR")
        bench.system.reset("Drive0")
        bench.until("INACTIVE")
        bench.run(10)
        assert bench.state == "INACTIVE"
