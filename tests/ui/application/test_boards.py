"""Calls to a TECS board on a page: the octets of each, and how long it took."""

from __future__ import annotations

from ui_bench import ROOT, Bench, whole

from rtgen.runtime import xcdr
from rtgen.ui.protocol import ui

SYSTEM = ROOT / "specs/tecs/rh3_board.xml"


def test_calls_are_shown_and_made() -> None:
    bench = Bench(SYSTEM)
    page = bench.page()
    state = whole(page.events())
    page.done("step", 0.2)
    calls = [
        e.call for e in page.seen if e.discriminator is ui.EventKind.EVENT_BOARD_CALL
    ]
    assert calls
    assert {call.instance for call in calls} == {"OpaqueRpcCommunication0"}
    assert all(call.request[:2] == b"\x67\x2a" and not call.error for call in calls)
    # Simulated time stands still meanwhile, real time does not.
    assert all(call.round_trip > 0.0 for call in calls)
    drive = next(c for c in calls if c.function == "sMotorBoard.drive")
    speed, count = drive.request_values
    assert (speed.name, speed.text[0], count.name, count.text) == (
        *("speed", "["),
        *("count", "2"),
    )
    assert drive.reply_values[1].text.startswith("{time: ")
    marshaller = next(
        c for c in state.components if c.instance == "MotorBoardMarshaller0"
    )
    port = next(p for p in marshaller.ports if p.interfaces[0].provided)
    interface = port.interfaces[0]
    operation = next(o for o in interface.operations if o.name == "identify")
    assert not operation.refused
    assert state.types[operation.reply].kind is ui.TypeKind.TYPE_STRUCT
    address = ui.PortAddress(marshaller.instance, port.name)
    reply = page.done("called", ui.Call(address, interface.name, "identify", b"")).reply
    assert b"RH3 motor board, simulated" in reply
    assert reply[1] == xcdr.Representation.CDR_LE
    [call] = [
        e.call for e in page.seen if e.discriminator is ui.EventKind.EVENT_BOARD_CALL
    ]
    assert call.request == b"\x67\x2a\x00\x01\x5a\x3c"
    assert b"RH3 motor board, simulated" in call.reply
    assert call.function == "sMotorBoard.identify"
    assert not call.request_values
    values = [("return", "0"), ("name", "RH3 motor board, simulated")]
    assert [(each.name, each.text) for each in call.reply_values] == values
    bench.close()
