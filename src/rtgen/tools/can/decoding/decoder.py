"""Decodes CANopen frames (CiA 301, CiA 305) into text and values."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace

from rtgen.compiler.model.canopen import INVALID, PdoDirection
from rtgen.facts.cob_ids import (
    COB_ID_EMERGENCY,
    COB_ID_SYNC,
    COB_ID_TIME,
    SDO_SERVERS,
)
from rtgen.runtime.canopen.wire.emergency import Emergency, ErrorRegister
from rtgen.runtime.canopen.wire.frames import (
    EMERGENCY,
    ERROR_CONTROL,
    LSS_REQUEST,
    LSS_RESPONSE,
    MAX_NODE_ID,
    NMT,
    SDO_REQUEST,
    SDO_RESPONSE,
    SYNC,
    TIME,
    CobId,
    Frame,
)
from rtgen.runtime.canopen.wire.nmt import NmtCommand, NmtState
from rtgen.runtime.canopen.wire.sync import decode_time, sync_counter
from rtgen.tools.can.decoding.lss_text import lss_text
from rtgen.tools.can.decoding.node_index import DescribedNode, NodeIndex, Number
from rtgen.tools.can.decoding.object_values import Field, field_of, iso_time, sdo_value
from rtgen.tools.can.decoding.pdo_fields import Route, object_of, routes
from rtgen.tools.can.decoding.sdo_decoding import SdoFollower, SdoStep
from rtgen.tools.rpc.values import Json

_FAILSAFE = 0x001
_FIRST_SERVER = SDO_SERVERS.start
_SDO = 8
"""Length of every SDO message in octets."""
_PREDEFINED_PDOS = range(0x180, 0x580)
_ID_MASK = 0x7F

COMMAND_TEXTS = {
    NmtCommand.START: "start",
    NmtCommand.STOP: "stop",
    NmtCommand.ENTER_PRE_OPERATIONAL: "enter pre-operational",
    NmtCommand.RESET_NODE: "reset node",
    NmtCommand.RESET_COMMUNICATION: "reset communication",
}
STATE_TEXTS = {
    NmtState.INITIALISING: "boot-up",
    NmtState.STOPPED: "stopped",
    NmtState.OPERATIONAL: "operational",
    NmtState.PRE_OPERATIONAL: "pre-operational",
}


@dataclass(frozen=True, slots=True)
class Decoded:
    """A decoded frame.

    `kind` is nmt, failsafe, sync, time, emcy, heartbeat, guarding, tpdo1.., rpdo1.., sdo, lss, or
    frame for an unknown identifier. `node` is the node-id that the frame concerns (0: all nodes;
    None: no node in particular), `name` the display name of that node. `code` is an emergency
    error code or an SDO abort code. `fields` are the values as the sender maps them, `taken`
    those as each receiver of a linked PDO maps them.
    """

    kind: str
    node: int | None
    name: str
    text: str
    fields: tuple[Field, ...] = ()
    code: int | None = None
    taken: tuple[Field, ...] = ()

    def __str__(self) -> str:
        words = (self.name, self.kind, self.text)
        return " ".join(word for word in words if word)

    def to_json(self) -> dict[str, Json]:
        """Return a JSON object with the attributes that are set; `fields` become `values`."""
        result: dict[str, Json] = {"kind": self.kind}
        if self.node is not None:
            result |= {"node": self.node, "name": self.name}
        result["text"] = self.text
        if self.code is not None:
            result["code"] = self.code
        if self.fields:
            result["values"] = [field.to_json() for field in self.fields]
        return result


class Decoder:
    """Decodes the frames of one bus in order of arrival.

    It follows SDO transfers, so that a change of a node's PDO parameters applies to later frames.
    A boot-up message resets a node's parameters to those of its description.
    """

    def __init__(self, node_index: NodeIndex) -> None:
        self.known = node_index
        self._followers: defaultdict[tuple[int, int], SdoFollower] = defaultdict(
            SdoFollower
        )
        """The transfers by node-id and index of the server's parameters."""
        self._parameters: dict[int, dict[Number, int]] = {}
        self._routes: dict[tuple[int, bool], list[Route]] = {}
        self._emergencies: dict[tuple[int, bool], int] = {}
        self._servers: dict[tuple[int, bool], tuple[int, int, bool]] = {}
        self._syncs: set[tuple[int, bool]] = set()
        self._times: set[tuple[int, bool]] = set()
        self._further_servers: dict[int, list[int]] = {}
        for node in node_index.nodes.values():
            parameters = self._parameters[node.id] = node.parameters
            self._further_servers[node.id] = sorted(
                {index for index, _ in parameters if index in SDO_SERVERS[1:]}
            )
        self._wire()

    def decode(self, frame: Frame) -> Decoded:
        """Decode the next frame."""
        key = frame.can_id, frame.extended
        if key == (NMT, False):
            return self._command(frame)
        if key in self._routes:
            return self._pdo(self._routes[key], frame)
        if key in self._emergencies:
            return self._emergency(self._emergencies[key], frame)
        if key in self._syncs:
            return self._sync(frame)
        if key in self._times:
            return self._time(frame)
        if key in self._servers:
            node_id, server, is_request = self._servers[key]
            return self._sdo(node_id, frame, server=server, request=is_request)
        if frame.extended:
            return _unknown(frame)
        return self._predefined(frame)

    # Identifiers

    def _wire(self) -> None:
        """Rebuild the tables from identifier to message, from the nodes' parameters."""
        by_identifier: defaultdict[tuple[int, bool], list[Route]] = defaultdict(list)
        self._emergencies, self._servers = {}, {}
        self._syncs, self._times = {(SYNC, False)}, {(TIME, False)}
        for node in self.known.nodes.values():
            parameters = self._parameters[node.id]
            for key, route in routes(node, parameters):
                by_identifier[key].append(route)
            for number, keys in (
                (COB_ID_SYNC, self._syncs),
                (COB_ID_TIME, self._times),
            ):
                cob_id = _word(parameters.get(number, 0))
                if cob_id.configurable:
                    keys.add((cob_id.can_id, cob_id.extended))
            cob_id = _word(parameters.get(COB_ID_EMERGENCY, INVALID))
            if cob_id.valid:
                self._emergencies[cob_id.can_id, cob_id.extended] = node.id
            for server in self._further_servers[node.id]:
                self._add_server(node.id, server, parameters)
        for sharing in by_identifier.values():
            sharing.sort(key=lambda r: r.direction is PdoDirection.RPDO)
        self._routes = dict(by_identifier)

    def _add_server(
        self, node_id: int, server: int, parameters: dict[Number, int]
    ) -> None:
        """Add the identifiers of a further SDO server, if it is valid."""
        cob_ids = [_word(parameters.get((server, sub), INVALID)) for sub in (1, 2)]
        if all(cob_id.valid for cob_id in cob_ids):
            for cob_id, is_request in zip(cob_ids, (True, False), strict=True):
                key = cob_id.can_id, cob_id.extended
                self._servers[key] = node_id, server, is_request

    def _predefined(self, frame: Frame) -> Decoded:
        """Decode a frame of the predefined connection set (CiA 301, 7.3.3)."""
        can_id = frame.can_id
        if can_id == _FAILSAFE:
            return Decoded("failsafe", None, "", frame.data.hex(" "))
        if can_id in (LSS_REQUEST, LSS_RESPONSE):
            text = lss_text(frame.data, request=can_id == LSS_REQUEST)
            return Decoded("lss", None, "", text)
        base, node_id = can_id & ~_ID_MASK, can_id & _ID_MASK
        if not node_id:
            return _unknown(frame)
        if base == EMERGENCY:
            return self._emergency(node_id, frame)
        if base in (SDO_REQUEST, SDO_RESPONSE):
            return self._sdo(node_id, frame, request=base == SDO_REQUEST)
        if base == ERROR_CONTROL:
            return self._heartbeat(node_id, frame)
        if base in _PREDEFINED_PDOS and node_id not in self.known.nodes:
            number, received = divmod(base - 0x180, 0x100)
            kind = f"{'rpdo' if received else 'tpdo'}{number + 1}"
            return self._about(kind, node_id, _raw(frame))
        return _unknown(frame)

    def _about(
        self,
        kind: str,
        node_id: int,
        text: str,
        fields: tuple[Field, ...] = (),
        code: int | None = None,
    ) -> Decoded:
        name = self.known.name(node_id) if node_id else "all nodes"
        return Decoded(kind, node_id, name, text, fields, code)

    # NMT, SYNC, TIME, EMCY and error control

    def _command(self, frame: Frame) -> Decoded:
        data = frame.data
        if frame.remote or len(data) != 2 or data[1] > MAX_NODE_ID:
            return Decoded("nmt", None, "", f"no command: {_raw(frame)}")
        try:
            text = COMMAND_TEXTS[NmtCommand(data[0])]
        except ValueError:
            text = f"unknown command {data[0]:02X}h"
        return self._about("nmt", data[1], text)

    def _sync(self, frame: Frame) -> Decoded:
        counter = sync_counter(frame)
        if counter is None:
            return Decoded("sync", None, "", f"of a wrong length: {_raw(frame)}")
        return Decoded("sync", None, "", str(counter) if counter else "")

    def _time(self, frame: Frame) -> Decoded:
        plain = Frame(TIME, frame.data, frame.remote)
        moment = decode_time(plain)
        if moment is None:
            return Decoded("time", None, "", f"no time: {_raw(frame)}")
        return Decoded("time", None, "", iso_time(moment))

    def _emergency(self, node_id: int, frame: Frame) -> Decoded:
        data = frame.data
        if frame.remote or len(data) != 8:
            return self._about("emcy", node_id, f"no emergency: {_raw(frame)}")
        code = int.from_bytes(data[:2], "little")
        emergency = Emergency(code, ErrorRegister(data[2]), data[3:])
        text = str(emergency)
        if any(emergency.additional):
            text += f" {emergency.additional.hex(' ')}"
        return self._about("emcy", node_id, text, code=code)

    def _heartbeat(self, node_id: int, frame: Frame) -> Decoded:
        if frame.remote:
            return self._about("guarding", node_id, "request")
        if len(frame.data) != 1:
            return self._about("heartbeat", node_id, f"no state: {_raw(frame)}")
        try:
            state = NmtState(frame.data[0] & 0x7F)
        except ValueError:
            text = f"unknown state {frame.data[0]:02X}h"
            return self._about("heartbeat", node_id, text)
        if frame.data[0] & 0x80:
            text = f"{STATE_TEXTS[state]} (toggle bit set)"
            return self._about("guarding", node_id, text)
        if state is NmtState.INITIALISING:
            self._booted(node_id)
        return self._about("heartbeat", node_id, STATE_TEXTS[state])

    def _booted(self, node_id: int) -> None:
        for key in [key for key in self._followers if key[0] == node_id]:
            del self._followers[key]
        node = self.known.nodes.get(node_id)
        if node is not None and self._parameters[node_id] != node.parameters:
            self._parameters[node_id] = node.parameters
            self._wire()

    # PDOs

    def _pdo(self, sharing: list[Route], frame: Frame) -> Decoded:
        route = sharing[0]
        producing = route.direction is PdoDirection.TPDO
        takers = sharing[1:] if producing else []
        receivers = "".join(f"-> {r.node.name}.{r.pdo} " for r in takers)
        kind, node_id = route.pdo, route.node.id
        if frame.remote:
            return self._about(kind, node_id, "request")
        fields = route.fields(frame.data)
        words = [", ".join(map(str, fields))]
        if len(frame.data) < route.octets:
            words.append(f"(too short: {len(frame.data)} of {route.octets} octets)")
        elif len(frame.data) > route.octets:
            words.append(f"(too long: {len(frame.data)} octets for {route.octets})")
        text = receivers + " ".join(words)
        taken = tuple(f for taker in takers for f in taker.fields(frame.data))
        return replace(self._about(kind, node_id, text.rstrip(), fields), taken=taken)

    # SDO

    def _sdo(
        self, node_id: int, frame: Frame, *, request: bool, server: int = _FIRST_SERVER
    ) -> Decoded:
        if frame.remote or len(frame.data) != _SDO:
            return self._about("sdo", node_id, f"no message: {_raw(frame)}")
        follower = self._followers[node_id, server]
        step = (
            follower.request(frame.data) if request else follower.response(frame.data)
        )
        node = self.known.nodes.get(node_id)
        fields: tuple[Field, ...] = ()
        words = [step.verb]
        if step.number is not None:
            thing = object_of(node, step.number)
            words.append(str(thing))
            if step.value is not None:
                value = sdo_value(thing, step.value)
                fields = (field_of(node, thing, value),)
                words.append(f"= {fields[0].text}")
        if step.detail:
            words.append(step.detail if step.value is None else f"({step.detail})")
        self._learn(node, step)
        return self._about("sdo", node_id, " ".join(words), fields, step.abort)

    def _learn(self, node: DescribedNode | None, step: SdoStep) -> None:
        """Record a communication parameter whose value a transfer has shown."""
        if node is None or step.number is None or not step.holds:
            return
        if not 0x1000 <= step.number[0] < 0x2000 or step.number not in node.objects:
            return
        value = sdo_value(node.objects[step.number], step.holds)
        parameters = self._parameters[node.id]
        if not isinstance(value, int) or parameters.get(step.number) == value:
            return
        parameters[step.number] = value
        self._wire()


def _word(cob_id: int) -> CobId:
    return CobId(cob_id & 0xFFFFFFFF)


def _raw(frame: Frame) -> str:
    return "remote frame" if frame.remote else frame.data.hex(" ") or "no data"


def _unknown(frame: Frame) -> Decoded:
    return Decoded("frame", None, "", _raw(frame))
