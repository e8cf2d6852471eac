"""The slave's services, frame by frame: NMT gating, boot-up, heartbeat, SYNC, TIME, resets."""

from __future__ import annotations

import pytest
from device_bench import DEVICE, NODE_ID, Bench, var
from msgspec.structs import replace

from rtgen.runtime.canopen.node.node import DeviceNode
from rtgen.runtime.canopen.node.node_events import NodeEvents
from rtgen.runtime.canopen.wire import sdo
from rtgen.runtime.canopen.wire.frames import MILLISECOND, Frame
from rtgen.runtime.canopen.wire.heartbeat import HeartbeatNews
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState, Transition
from rtgen.runtime.canopen.wire.sdo import SdoAbort

HEARTBEAT = 0x700 + NODE_ID
EMERGENCY = 0x80 + NODE_ID
TPDO1 = 0x180 + NODE_ID
RPDO1 = 0x200 + NODE_ID


def test_boot_up_then_pre_operational() -> None:
    bench = Bench()
    assert bench.sent == [Frame(HEARTBEAT, b"\0")]
    assert bench.node.state is NmtState.PRE_OPERATIONAL


def test_nothing_is_served_before_boot_up() -> None:
    bench = Bench(boot=False)
    assert bench.give(0x600 + NODE_ID, bytes.fromhex("4000100000000000")) == []
    assert bench.command(NmtCommand.START) == []
    assert bench.node.state is NmtState.INITIALISING


@pytest.mark.parametrize(
    ("state", "command", "pdo", "sdo"),
    [
        (NmtState.PRE_OPERATIONAL, NmtCommand.ENTER_PRE_OPERATIONAL, False, True),
        (NmtState.OPERATIONAL, NmtCommand.START, True, True),
        (NmtState.STOPPED, NmtCommand.STOP, False, False),
    ],
)
def test_nmt_state_says_which_services_there_are(
    state: NmtState, command: NmtCommand, pdo: bool, sdo: bool
) -> None:
    bench = Bench()
    bench.command(command, 0)
    assert bench.node.state is state
    bench.give(RPDO1, bytes.fromhex("0f0001000000"))
    assert bench.node.get(0x6040) == (0x0F if pdo else 0)
    bench.node.set(0x6041, 0, 0x21)
    assert [f.can_id for f in bench.flush()] == ([TPDO1] if pdo else [])
    answers = bench.give(0x600 + NODE_ID, bytes.fromhex("4000100000000000"))
    assert [f.can_id for f in answers] == ([0x580 + NODE_ID] if sdo else [])
    bench.node.add_error(0x2310)
    assert [f.can_id for f in bench.flush()] == ([EMERGENCY] if sdo else [])
    bench.node.dictionary.put((0x1017, 0), b"\x0a\0")
    assert bench.flush() == []
    beats = bench.run(0)
    assert beats == [Frame(HEARTBEAT, bytes((state,)))]


def test_every_transition_is_reported() -> None:
    transitions: list[Transition] = []
    loaded: list[range] = []
    events = NodeEvents(moved=transitions.append, loaded=loaded.append)
    bench = Bench(DeviceNode(DEVICE, NODE_ID, events=events))
    bench.start()
    bench.command(NmtCommand.STOP)
    bench.command(NmtCommand.RESET_COMMUNICATION)
    states = [(t.before.name, t.after.name, t.command) for t in transitions]
    assert states == [
        ("INITIALISING", "PRE_OPERATIONAL", None),
        ("PRE_OPERATIONAL", "OPERATIONAL", NmtCommand.START),
        ("OPERATIONAL", "STOPPED", NmtCommand.STOP),
        ("STOPPED", "INITIALISING", NmtCommand.RESET_COMMUNICATION),
        ("INITIALISING", "PRE_OPERATIONAL", None),
    ]
    assert [0x2000 in indices for indices in loaded] == [True, False]


def test_its_owner_may_put_the_boot_up_off() -> None:
    bench = Bench(DeviceNode(DEVICE, NODE_ID, events=NodeEvents(ready=lambda: False)))
    assert bench.command(NmtCommand.RESET_NODE) == []
    assert bench.node.state is NmtState.INITIALISING
    assert bench.run(1000) == []
    assert bench.note(bench.node.boot(bench.now)) == [Frame(HEARTBEAT, b"\0")]
    assert bench.note(bench.node.boot(bench.now)) == []


@pytest.mark.parametrize("value", [8, 0, 4, 12, 1])
def test_self_starting(value: int) -> None:
    objects = [o for o in DEVICE.objects if o.index != 0x1F80]
    objects.append(var(0x1F80, 0, "u32", "rw", value))
    bench = Bench(DeviceNode(replace(DEVICE, objects=tuple(objects)), NODE_ID))
    wanted = NmtState.OPERATIONAL if value == 8 else NmtState.PRE_OPERATIONAL
    assert bench.node.state is wanted


# Heartbeat


def test_heartbeats_of_the_period_that_is_written() -> None:
    bench = Bench()
    assert bench.run(1000) == []
    bench.write(0x1017, 0, 100)
    beat = Frame(HEARTBEAT, bytes((NmtState.PRE_OPERATIONAL,)))
    assert bench.run(0) == [beat]
    assert bench.run(1000) == [beat] * 10
    bench.write(0x1017, 0, 0)
    assert bench.run(1000) == []


def test_guarding_is_answered_where_there_is_no_heartbeat() -> None:
    bench = Bench()
    first, second = (bench.give(HEARTBEAT, remote=True) for _ in range(2))
    assert [f.data for f in (*first, *second)] == [b"\x7f", b"\xff"]
    bench.write(0x1017, 0, 100)
    assert bench.give(HEARTBEAT, remote=True) == []


def watching(time: int, action: int = 0) -> tuple[Bench, list[HeartbeatNews]]:
    news: list[HeartbeatNews] = []
    events = NodeEvents(heard=lambda node_id, event: news.append(event.news))
    bench = Bench(DeviceNode(DEVICE, NODE_ID, events=events))
    bench.write(0x1029, 1, action)
    bench.write(0x1016, 1, 127 << 16 | time)
    bench.start()
    bench.sent.clear()
    return bench, news


def test_supervision_begins_with_the_first_heartbeat() -> None:
    bench, news = watching(100)
    assert bench.run(1000) == []
    bench.give(0x77F, b"\x05")
    assert bench.node.deadline == bench.now + 100 * MILLISECOND
    assert bench.run(99) == []
    lost = bench.run(1)
    assert lost == [Frame(EMERGENCY, bytes.fromhex("308111 7f00000000"))]
    assert bench.node.state is NmtState.PRE_OPERATIONAL
    assert bench.node.get(0x1001) == 0x11
    back = bench.give(0x77F, b"\x05")
    assert back == [Frame(EMERGENCY, bytes.fromhex("000000 7f00000000"))]
    assert bench.node.get(0x1001) == 0
    assert news == [HeartbeatNews.FOUND, HeartbeatNews.LOST, HeartbeatNews.FOUND]


@pytest.mark.parametrize(
    ("action", "state"),
    [
        (0, NmtState.PRE_OPERATIONAL),
        (1, NmtState.OPERATIONAL),
        (2, NmtState.STOPPED),
    ],
)
def test_error_behaviour(action: int, state: NmtState) -> None:
    bench, _ = watching(100, action)
    bench.give(0x77F, b"\x05")
    assert [frame.can_id for frame in bench.run(200)] == [EMERGENCY]
    assert bench.node.state is state


def test_a_heartbeat_that_jitters_within_the_time_is_not_lost() -> None:
    bench, news = watching(100)
    for pause in (99, 1, 50, 99.9, 0.1, 80):
        bench.give(0x77F, b"\x05")
        assert bench.run(pause) == []
    assert news == [HeartbeatNews.FOUND]


def test_two_consumers_of_one_node_cannot_be() -> None:
    bench = Bench()
    bench.write(0x1016, 1, 127 << 16 | 100)
    assert bench.refusal(0x1016, 2, 127 << 16 | 200) == 0x06040043
    assert bench.refusal(0x1016, 2, 127 << 16) == 0
    assert bench.refusal(0x1016, 2, 7 << 16 | 200) == 0
    assert bench.refusal(0x1016, 1, 7 << 16 | 100) == 0x06040043
    assert bench.refusal(0x1016, 1, 127 << 16 | 300) == 0
    assert {0x77F, 0x707} <= bench.node.identifiers
    assert bench.refusal(0x1016, 1, 0) == 0
    assert 0x77F not in bench.node.identifiers


def test_a_node_that_is_not_watched_any_more_is_no_error() -> None:
    bench, _ = watching(100)
    bench.give(0x77F, b"\x05")
    bench.run(200)
    assert bench.node.get(0x1001) == 0x11
    bench.write(0x1016, 1, 0)
    assert bench.node.get(0x1001) == 0


# Emergencies


def test_errors_come_and_go_in_register_and_history() -> None:
    bench = Bench()
    bench.node.add_error(0x2310, b"\x01\x02")
    bench.node.add_error(0x2310, b"\x01\x02")
    bench.node.add_error(0x4210)
    assert [f.data.hex() for f in bench.flush()] == [
        "1023030102000000",
        "10420b0000000000",
    ]
    assert bench.read(0x1001) == b"\x0b"
    assert bench.read(0x1003) == b"\x02"
    assert bench.read(0x1003, 1).hex() == "10420000"
    assert bench.read(0x1003, 2).hex() == "10230102"
    with pytest.raises(SdoAbort, match="08000024h"):
        bench.read(0x1003, 3)
    bench.node.remove_error(0x2310)
    bench.node.remove_error(0x2310)
    assert [f.data.hex() for f in bench.flush()] == ["0000090102000000"]
    bench.node.remove_error(0x4210)
    assert [f.data.hex() for f in bench.flush()] == ["0000000000000000"]
    assert bench.read(0x1003) == b"\x02"
    assert bench.refusal(0x1003, 0, 1) == sdo.VALUE_INVALID
    bench.write(0x1003, 0, 0)
    with pytest.raises(SdoAbort, match="08000024h"):
        bench.read(0x1003, 1)


def test_history_keeps_the_newest() -> None:
    bench = Bench()
    for code in range(0xFF01, 0xFF08):
        bench.node.add_error(code)
    assert bench.read(0x1003) == b"\x04"
    kept = [int.from_bytes(bench.read(0x1003, sub), "little") for sub in (1, 2, 3, 4)]
    assert kept == [0xFF07, 0xFF06, 0xFF05, 0xFF04]
    assert bench.read(0x1001) == b"\x81"


def test_a_storm_of_errors_is_bounded() -> None:
    bench = Bench()
    bench.write(0x1015, 0, 10)
    bench.sent.clear()
    for number in range(1000):
        bench.node.add_error(0xFF00, number.to_bytes(2, "little"))
        bench.node.remove_error(0xFF00, number.to_bytes(2, "little"))
        bench.flush()
    frames = [*bench.sent, *bench.run(1000)]
    assert len(frames) == 17
    assert bench.node.errors.lost == 2000 - 17
    assert frames[-1].data[:3] == bytes(3)
    assert int.from_bytes(frames[-1].data[3:5], "little") == 999
    for number in range(1000):
        bench.node.add_error(0xFF00, number.to_bytes(2, "little"))
    bench.run(1000)
    assert bench.read(0x1001) == b"\x81"


def test_emergencies_keep_their_inhibit_time() -> None:
    bench = Bench()
    bench.write(0x1015, 0, 50)
    for code in (0xFF01, 0xFF02, 0xFF03):
        bench.node.add_error(code)
    bench.node.flush(bench.now)
    assert bench.node.deadline == bench.now + 5 * MILLISECOND
    assert bench.run(4.9) == []
    assert [f.data[0] for f in bench.run(0.1)] == [2]
    assert [f.data[0] for f in bench.run(5)] == [3]
    assert bench.node.deadline is None


def test_what_happens_in_stopped_is_reported_afterwards() -> None:
    bench = Bench()
    bench.command(NmtCommand.STOP)
    bench.node.add_error(0xFF01)
    assert bench.flush() == []
    assert bench.node.deadline is None
    frames = bench.command(NmtCommand.ENTER_PRE_OPERATIONAL)
    assert [f.data[:2].hex() for f in frames] == ["01ff"]


def test_cob_id_of_the_emergency_message() -> None:
    bench = Bench()
    assert bench.refusal(0x1014, 0, 0x90) == sdo.VALUE_INVALID
    assert bench.refusal(0x1014, 0, 0x80000090) == 0
    bench.node.add_error(0xFF01)
    assert bench.flush() == []
    assert bench.refusal(0x1014, 0, 0x101) == sdo.VALUE_INVALID
    assert bench.refusal(0x1014, 0, 0x890) == sdo.VALUE_INVALID
    assert bench.refusal(0x1014, 0, 0x90) == 0
    bench.node.add_error(0xFF02)
    assert [f.can_id for f in bench.flush()] == [0x90]


def test_an_application_that_fails_tells_why_and_stops() -> None:
    bench = Bench()
    bench.write(0x1015, 0, 10000)
    bench.write(0x1017, 0, 100)
    bench.start()
    bench.node.add_error(0x3210)
    bench.flush()
    frames = bench.note(bench.node.fail(bench.now, 0x6200, b"\x07"))
    assert [f.data.hex() for f in frames] == ["0062050700000000"]
    assert bench.node.state is NmtState.STOPPED
    assert Frame(HEARTBEAT, b"\x04") in bench.run(100)
    bench.command(NmtCommand.RESET_NODE)
    assert bench.node.get(0x1001) == 0


# SYNC and TIME


def test_syncs_of_the_wrong_length_are_an_error_until_a_right_one_comes() -> None:
    bench = Bench()
    bench.start()
    assert bench.give(0x80) == []
    wrong = bench.give(0x80, b"\x01")
    assert [f.data.hex() for f in wrong] == ["4082110000000000"]
    assert bench.give(0x80, b"\x01\x02") == []
    assert [f.data.hex() for f in bench.give(0x80)] == ["0000000000000000"]
    bench.write(0x1019, 0, 10)
    assert bench.give(0x80, b"\x01") == []
    assert [f.data[:2].hex() for f in bench.give(0x80)] == ["4082"]


def test_without_a_counter_object_both_lengths_will_do() -> None:
    objects = tuple(o for o in DEVICE.objects if o.index != 0x1019)
    bench = Bench(DeviceNode(replace(DEVICE, objects=objects), NODE_ID))
    bench.start()
    assert bench.give(0x80) == bench.give(0x80, b"\x07") == []
    assert [f.data[:2].hex() for f in bench.give(0x80, bytes(2))] == ["4082"]


@pytest.mark.parametrize(
    ("value", "code"), [(0, 0), (1, 1), (2, 0), (240, 0), (241, 1)]
)
def test_sync_counter_overflow(value: int, code: int) -> None:
    bench = Bench()
    assert bench.refusal(0x1019, 0, value) == (sdo.VALUE_INVALID if code else 0)
    bench.write(0x1006, 0, 1000)
    assert bench.refusal(0x1019, 0, 3) == sdo.DEVICE_STATE


def test_a_device_may_produce_sync() -> None:
    bench = Bench()
    bench.write(0x1019, 0, 3)
    bench.write(0x1006, 0, 10_000)
    assert bench.run(100) == []
    bench.write(0x1005, 0, 0x40000080)
    syncs = [*bench.sent, *bench.run(30)]
    assert [f.data for f in syncs if f.can_id == 0x80] == [b"\1", b"\2", b"\3", b"\1"]
    assert bench.refusal(0x1005, 0, 0x40000081) == sdo.VALUE_INVALID
    bench.command(NmtCommand.STOP)
    assert bench.run(30) == []
    bench.command(NmtCommand.ENTER_PRE_OPERATIONAL)
    assert [f.data for f in bench.run(10)][:1] == [b"\1"]
    bench.write(0x1005, 0, 0x80)
    assert bench.run(30) == []


def test_sync_identifier_may_be_another_one() -> None:
    bench = Bench()
    assert bench.refusal(0x1005, 0, 0x101) == sdo.VALUE_INVALID
    bench.write(0x1005, 0, 0x90)
    assert 0x90 in bench.node.identifiers
    bench.start()
    assert bench.give(0x90, bytes(2)) != []


@pytest.mark.parametrize("consumer", [False, True])
def test_time(consumer: bool) -> None:
    moments: list[int] = []
    bench = Bench(DeviceNode(DEVICE, NODE_ID, events=NodeEvents(time=moments.append)))
    bench.write(0x1012, 0, 0x80000100 if consumer else 0x100)
    assert bench.refusal(0x1012, 0, 0x80000601) == sdo.VALUE_INVALID
    now = 1_700_000_000 * 10**9
    assert (0x100 in bench.node.identifiers) == consumer
    time = Frame(0x100, bytes.fromhex("00b4c404e238"))
    bench.note(bench.node.receive(time, 0))
    bench.give(0x100, bytes(5))
    assert moments == ([now] if consumer else [])


# Two nodes, one id


@pytest.mark.parametrize("can_id", [HEARTBEAT, EMERGENCY, 0x580 + NODE_ID])
def test_another_node_of_the_same_id_is_noticed_once(can_id: int) -> None:
    collisions: list[int] = []
    bench = Bench(
        DeviceNode(DEVICE, NODE_ID, events=NodeEvents(collided=collisions.append))
    )
    frames = [f for _ in range(3) for f in bench.give(can_id, bytes(8))]
    assert [f.data[:3].hex() for f in frames] == ["508111"]
    assert collisions == [can_id]


# Bus off and recovery


@pytest.mark.parametrize(
    ("action", "state"),
    [
        (0, NmtState.PRE_OPERATIONAL),
        (1, NmtState.OPERATIONAL),
        (2, NmtState.STOPPED),
    ],
)
def test_bus_off_and_return(action: int, state: NmtState) -> None:
    bench = Bench()
    bench.write(0x1029, 1, action)
    bench.start()
    bench.give(0x600 + NODE_ID, bytes.fromhex("2100200020000000"))
    bench.note(bench.node.link_changed(False, bench.now))
    assert bench.node.state is state
    back = bench.note(bench.node.link_changed(True, bench.now))
    emergencies = [f.data[:2].hex() for f in back]
    assert emergencies == ([] if state is NmtState.STOPPED else ["4081"])
    assert bench.run(5000) == []


# Resets and stored parameters


def test_reset_communication_leaves_the_application_alone() -> None:
    bench = Bench()
    bench.write(0x1017, 0, 100)
    bench.write(0x2103, 0, 50)
    bench.command(NmtCommand.RESET_COMMUNICATION)
    assert bench.node.get(0x1017) == 0
    assert bench.node.get(0x2103) == 50
    assert bench.run(1000) == []
    bench.write(0x2103, 0, 50)
    bench.command(NmtCommand.RESET_NODE)
    assert bench.node.get(0x2103) == 0


SAVE, LOAD = b"save", b"load"


@pytest.mark.parametrize(
    ("group", "kept"),
    [(1, {0x1017, 0x2103, 0x607A}), (2, {0x1017}), (3, {0x607A}), (4, {0x2103})],
)
def test_stored_parameters_come_back(group: int, kept: set[int]) -> None:
    bench = Bench()
    values = {0x1017: 1000, 0x2103: 50, 0x607A: 7}
    for index, value in values.items():
        bench.write(index, 0, value)
    bench.write(0x1010, group, SAVE)
    assert bench.read(0x1010, group) == b"\1\0\0\0"
    bench.command(NmtCommand.RESET_NODE)
    for index, value in values.items():
        assert bench.node.get(index) == (value if index in kept else 0)
    if 0x1017 in kept:
        assert bench.run(1000) != []


def test_restored_defaults_take_effect_after_a_reset() -> None:
    bench = Bench()
    bench.write(0x2103, 0, 50)
    bench.write(0x1017, 0, 1000)
    bench.write(0x1010, 1, SAVE)
    bench.write(0x1011, 2, LOAD)
    assert bench.node.get(0x1017) == 1000
    bench.command(NmtCommand.RESET_NODE)
    assert bench.node.get(0x1017) == 0
    assert bench.node.get(0x2103) == 50
    bench.write(0x1011, 1, LOAD)
    assert bench.node.get(0x2103) == 50
    bench.command(NmtCommand.RESET_NODE)
    assert bench.node.get(0x2103) == 0


@pytest.mark.parametrize(("index", "other"), [(0x1010, LOAD), (0x1011, SAVE)])
def test_only_the_signature_stores_and_restores(index: int, other: bytes) -> None:
    bench = Bench()
    assert bench.refusal(index, 1, other) == 0x08000020
    assert bench.refusal(index, 1, 1) == 0x08000020
    assert bench.refusal(index, 5, SAVE) == sdo.NO_SUBINDEX


def test_stored_communication_parameters_take_effect_at_reset_communication() -> None:
    bench = Bench()
    bench.write(0x1017, 0, 100)
    bench.write(0x1010, 2, SAVE)
    bench.write(0x1017, 0, 0)
    bench.command(NmtCommand.RESET_COMMUNICATION)
    assert bench.node.get(0x1017) == 100


def test_errors_of_the_application_outlive_reset_communication() -> None:
    bench = Bench()
    bench.start()
    bench.node.add_error(0x2310)
    bench.give(0x80, bytes(2))
    assert bench.node.get(0x1001) == 0x13
    bench.command(NmtCommand.RESET_COMMUNICATION)
    assert bench.node.get(0x1001) == 0x03
    assert bench.read(0x1003) == b"\0"
    bench.command(NmtCommand.RESET_NODE)
    assert bench.node.get(0x1001) == 0
