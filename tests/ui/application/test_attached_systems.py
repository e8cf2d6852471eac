"""What pages attached to `rtgen run` show of its buses, boards, timeline and latencies."""

from __future__ import annotations

import pytest
from attached_program import running, watching
from ui_bench import ROOT

from rtgen.cli import run as rtgen
from rtgen.runtime.distribution import local_runs
from rtgen.runtime.distribution.local_link import LocalLink
from rtgen.ui.protocol import ui

FOURX = ROOT / "specs/canopen/fourx.xml"
BUS = ROOT / "specs/canopen/fourx.toml"
BOARD = ROOT / "specs/tecs/rh3_board.xml"
LEADERS = ROOT / "specs/experiments/leader_exchange"
GOAL = ROOT / "specs/navigation/rh3_goal.xml"
pytestmark = pytest.mark.usefixtures("sockets")
PACED = ("--clock", "sim", "--rate", "1", "-q")


@pytest.mark.nightly
def test_frames_nodes_and_objects_of_its_buses() -> None:
    with (
        running(str(FOURX), *PACED) as program,
        watching(program.path, buses={"": BUS}) as page,
    ):
        kinds = {"heartbeat", "tpdo1"}
        page.until(lambda: kinds <= {each.kind for each in page.frames})
        [name] = page.buses
        page.until(
            lambda: {each.nmt_state for each in page.buses[name].nodes}
            == {"operational"}
        )
        assert page.buses[name].nodes[0].name == "front_left"
        assert any(each.numeric for frame in page.frames for each in frame.fields)
        times = [each.time for each in page.frames]
        assert times == sorted(times)
        objects = page.done("node", ui.NodeAddress(name, 1)).objects
        assert {each.index for each in objects} > {0x1000, 0x1017}
        access = ui.SdoAccess(name, 1, 0x1017, 0, "")
        before = page.done("read", access).text
        access.text = "150"
        page.done("written", access)
        assert page.done("read", access).text.startswith("150") != (before == "150")
        refused = page.ask("read", ui.SdoAccess(name, 1, 0x5FFF, 0, ""))
        assert not refused.done
        assert "06020000h" in refused.message
        page.done("managed", ui.NmtCommand(name, 1, "stop"))
        page.until(lambda: any(f.text == "stop" for f in page.frames))
        page.until(lambda: page.buses[name].nodes[0].nmt_state == "stopped")
        page.done("frame", ui.SendFrame(name, 0x7AB, data=b"\x01\x02", period=0.01))
        page.until(lambda: [f.can_id for f in page.frames].count(0x7AB) > 3)
        page.done("frame", ui.SendFrame(name, 0x7AB))
        refused = page.ask("frame", ui.SendFrame(name, 0x7AB, period=1e-6))
        assert "period" in refused.message


@pytest.mark.nightly
def test_calls_to_its_boards() -> None:
    with running(str(BOARD), *PACED) as program, watching(program.path) as page:
        drive = page.until(
            lambda: next((c for c in page.calls if c.function.endswith("drive")), None)
        )
        assert [each.name for each in drive.request_values] == ["speed", "count"]
        assert drive.reply_values
        assert drive.round_trip > 0.0
        assert drive.instance == "OpaqueRpcCommunication0"


@pytest.mark.sampled(0)
def test_its_timeline_and_the_times_of_its_states() -> None:
    with (
        running(str(LEADERS), *PACED) as program,
        watching(program.path) as page,
    ):
        page.until(lambda: page.plan)
        [*kinds] = {each.kind for each in page.plan}
        assert "connect" in kinds
        assert any(each.target.port for each in page.plan)
        instance = next(
            name
            for name, each in page.components.items()
            if each.current is ui.State.STATE_ACTIVE
        )
        page.done("deactivated", [instance])
        change = page.until(
            lambda: next((e for e in page.changes if e.instance == instance), None)
        )
        assert change.after is ui.State.STATE_INACTIVE
        assert round(change.time * 1000) == pytest.approx(change.time * 1000)
        page.until(lambda: page.state(instance) is ui.State.STATE_INACTIVE)
        assert len([e for e in page.changes if e.instance == instance]) == 1


@pytest.mark.nightly
def test_latencies_of_its_chains() -> None:
    with running(str(GOAL), *PACED) as program, watching(program.path) as page:
        chain = page.until(lambda: next((c for c in page.chains if c.samples), None))
        assert chain.least <= chain.median <= chain.late <= chain.greatest < 10.0
        assert len(chain.ports) > 2


@pytest.mark.nightly
def test_two_pages_see_the_same_and_a_ninth_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with (
        running(str(GOAL), *PACED) as program,
        watching(program.path) as one,
        watching(program.path) as other,
    ):
        one.done("deactivated", ["Odometry0"])
        for page in (one, other):
            page.until(
                lambda page=page: page.state("Odometry0") is ui.State.STATE_INACTIVE
            )
        links = [LocalLink(program.path) for _ in range(local_runs.MAX_CLIENTS - 2)]
        with pytest.raises(OSError, match="8 programs are attached"):
            LocalLink(program.path)
        assert rtgen(["ui", "--attach", "--no-open"]) != 0
        assert "8 programs are attached to" in capsys.readouterr().err
        for each in links:
            each.close()
        one.until(lambda: LocalLink(program.path).close() or True)
