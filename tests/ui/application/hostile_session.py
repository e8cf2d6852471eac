"""A session in which each text of the protocol could be markup, code, or controls of the text."""

from __future__ import annotations

import itertools
import json
import struct
import uuid
from collections.abc import Iterator
from typing import Any, Final

from rtgen.ui.outbox import Outbox
from rtgen.ui.protocol import ui
from rtgen.ui.protocol.ui import CommandKind, TypeKind
from rtgen.ui.recorded import AtOnce, Recorded

TEXTS: Final = (
    "<img src=x onerror=document.title='broken'>",
    "javascript:document.title='broken'//\"'><script>document.title='broken'</script>",
    "</textarea></select></option></svg><svg onload=document.title='broken'>"
    "&lt;b&gt;&amp;&#x202e; {{7*7}} ${7*7} %s \\u003cb\\u003e",
    "\N{RIGHT-TO-LEFT OVERRIDE}gnp.exe \N{LEFT-TO-RIGHT ISOLATE} \N{HEBREW LETTER ALEF}",
    "two\nlines\r\n\tand a tab",
    "\x01\x07\x1b[31m \x7f \ufffe \N{ZERO WIDTH SPACE} \N{LINE SEPARATOR}",
    "W" * 300,
    " ".join(["word"] * 60),
    "__proto__",
    "constructor",
    'bus can0"] b\\\'c"',
)
_HEARTBEAT, _EMERGENCY = 0x700, 0x080
_OBJECTS = 0x2000
_DOUBLE, _STRING, _POINT = range(3)
_FIRST = 3
_OF_EACH = 4
"""The number of types of each text: a struct, an enum, a union, a request."""


def types() -> Iterator[ui.TypeNode]:
    """Yield the types whose names and members have each text."""

    def member(name: str, type_: int, **more: Any) -> ui.TypeMember:
        return ui.TypeMember(name=name, type=type_, **more)

    yield ui.TypeNode(kind=TypeKind.TYPE_DOUBLE, element=-1, key=-1)
    yield ui.TypeNode(kind=TypeKind.TYPE_STRING, element=-1, key=-1)
    yield _struct("Point", [member("x", _DOUBLE), member("y", _DOUBLE)])
    for i, text in enumerate(TEXTS):
        pose = [member("position", _POINT), member("heading", _DOUBLE)]
        own = [member(text, _DOUBLE), member(f"{text} text", _STRING)]
        yield _struct(text, [*own, *pose])
        enumerators = [
            member(f"{text} {j}", -1, labels=[j], is_default=False) for j in range(2)
        ]
        kind = TypeKind.TYPE_ENUM
        yield ui.TypeNode(
            kind=kind, name=text, bound=32, element=-1, key=-1, members=enumerators
        )
        first = _FIRST + _OF_EACH * i
        branches = [
            member(f"{text} {j}", _STRING, labels=[j], is_default=False)
            for j in range(2)
        ]
        kind = TypeKind.TYPE_UNION
        yield ui.TypeNode(
            kind=kind, name=text, element=first + 1, key=-1, members=branches
        )
        arguments = [
            member(f"{text} a", first + 1),
            member(f"{text} b", first + 2),
            member(f"{text} c", _STRING, optional=True),
        ]
        yield _struct(text, arguments)


def _struct(name: str, members: list[ui.TypeMember]) -> ui.TypeNode:
    kind = TypeKind.TYPE_STRUCT
    return ui.TypeNode(kind=kind, name=name, element=-1, key=-1, members=members)


def component(i: int, text: str) -> ui.Component:
    """Return a component with a text in all places; every fourth is one of another process."""
    first = _FIRST + _OF_EACH * i
    place = text if i % 4 == 3 else ""
    operations = [
        ui.Operation(name=text, request=first + 3, reply=first, doc=text),
        ui.Operation(name=f"{text} 2", request=-1, reply=-1, refused=text),
    ]
    interfaces = [
        ui.ServiceInterface(text, text, True, operations),
        ui.ServiceInterface(f"{text} 2", text, False, []),
    ]
    data = {"type": text, "unit": text, "doc": text}
    widgets = {
        "text": "",
        "slider": "0<=x<=1",
        "radio": f"({text},b)",
        "checkbox": f"({text},b)",
        "ordered_list": f"({text},b)",
        "": f"({text},b)",
        text: text,
    }
    parameters = [
        ui.Parameter(f"{text} {j}", text, text, text, constraint, widget, text)
        for j, (widget, constraint) in enumerate(widgets.items())
    ]
    values = [ui.Value(each.name, text) for each in parameters]
    return ui.Component(
        instance=f"{place}/{text}" if place else text,
        type=text,
        category=text,
        vendor=text,
        version=text,
        doc=text,
        place=place,
        current=ui.State.STATE_ERROR,
        reason=text,
        contexts=[ui.ExecutionContext(handle=0, rate=10.0, kind=text)],
        ports=[
            ui.Port(text, ui.PortKind.PORT_IN, type_number=first, **data),
            ui.Port(f"{text} 2", ui.PortKind.PORT_OUT, type_number=first, **data),
            ui.Port(f"{text} 3", ui.PortKind.PORT_OUT, type_number=-1, **data),
            ui.Port(
                f"{text} 4",
                ui.PortKind.PORT_SERVICE,
                type_number=-1,
                doc=text,
                interfaces=interfaces,
            ),
        ],
        parameters=parameters,
        configuration_sets=[
            ui.ConfigurationSet(text, values),
            ui.ConfigurationSet(f"{text} 2", values),
        ],
        active_set=text,
        observables=[text],
        silent=text if i % 8 == 7 else "",
    )


def channels() -> Iterator[ui.Channel]:
    """Yield the channels of components: of their types, of JSON, and of the compared run."""
    for i, text in enumerate(TEXTS):
        instance, first = component(i, text).instance, _FIRST + _OF_EACH * i
        port = ui.PortAddress(instance, f"{text} 2")
        yield ui.Channel(3 * i, port, first)
        yield ui.Channel(3 * i + 1, ui.PortAddress(instance, f"{text} 3"), -1)
        yield ui.Channel(3 * i + 2, port, first, beside=True)


def sample(number: int, time: float) -> ui.Sample:
    """Return a sample of a channel."""
    text = TEXTS[number // 3]
    if number % 3 == 1:
        data = json.dumps({text: time, "text": text, f"{text} 2": [text]}).encode()
    else:
        data = _pose(text, time)
    return ui.Sample(channel=number, time=time, data=data)


def _pose(text: str, number: float) -> bytes:
    """Encode a value of the struct of a text by XCDR1, little endian."""
    octets = text.encode() + b"\0"
    head = struct.pack("<dI", number, len(octets)) + octets
    head += bytes(-len(head) % 8)
    return b"\0\1\0\0" + head + struct.pack("<3d", number, 0.5, 1.0)


def bus(text: str) -> ui.Bus:
    """Return a bus with a text in all places."""
    nodes = [
        ui.BusNode(1, text, text, text),
        ui.BusNode(2, f"{text} 2", text, "operational"),
    ]
    return ui.Bus(text, 500_000, 0.25, nodes)


def traffic(text: str) -> Iterator[ui.Event]:
    """Yield frames with a text, and the load of its bus."""
    fields = [
        ui.FrameField(text, text, text, True, 1.0),
        ui.FrameField(f"{text} 2", text, text, False, 0.0),
    ]
    for can_id, kind, words in (
        *((_HEARTBEAT + 1, text, ""), (_HEARTBEAT + 2, text, text)),
        *((_EMERGENCY + 1, "emcy", text), (_EMERGENCY + 2, "emcy", "")),
    ):
        frame = ui.Frame(1.0, text, can_id, False, False, b"\1", kind, 1, words, fields)
        yield ui.Event.of_traffic([frame])
    yield ui.Event.of_carried(ui.BusLoad(text, 1.0, 0.2, 7))
    values = [ui.Value(text, text)]
    call = ui.BoardCall(*(1.0, text, text, b"\1<b>", b"\2", values, values), 1e-5, "")
    yield ui.Event.of_call(call)
    failed = ui.BoardCall(*(1.1, text, text, b"\1", b"", [], []), -1.0, text)
    yield ui.Event.of_call(failed)


def state() -> ui.SystemState:
    """Return the state of a system of these components, buses and names."""
    components = [component(i, text) for i, text in enumerate(TEXTS)]
    ends = [(each.instance, each.type) for each in components]
    connections = [
        ui.Connection(
            target,  # as an instance is named
            ui.PortAddress(source, f"{text} 2"),
            ui.PortAddress(target, other),
            [ui.Value(text, text)],
        )
        for (source, text), (target, other) in itertools.pairwise(ends)
    ]
    bindings = [
        binding
        for i, each in enumerate(TEXTS)
        for binding in (
            ui.Binding(each, ui.BindingKind.BINDING_CONTEXT, ""),
            ui.Binding(
                f"{each}/{each} 2",
                (ui.BindingKind.BINDING_COMPONENT, ui.BindingKind.BINDING_DEAD)[i % 2],
                components[i].instance if i % 4 == 3 else "",
            ),
        )
    ]
    return ui.SystemState(
        name=TEXTS[0],
        types=[*types()],
        components=components,
        connections=connections,
        palette=[
            ui.PaletteEntry(each, each, each, component(i, each).ports)
            for i, each in enumerate(TEXTS)
        ],
        channels=[*channels()],
        time=ui.ClockState(kind=ui.ClockKind.CLOCK_SIMULATED, speed=1.0, now=2.0),
        edits=ui.EditState(TEXTS[1], TEXTS[3], saved=False, file=TEXTS[6]),
        buses=[bus(each) for each in TEXTS],
        systems=[*TEXTS],
        beside=TEXTS[7],
        naming=[
            *(ui.NamingService(each, each, []) for each in TEXTS),
            ui.NamingService("127.0.0.1:2809", "", bindings),
        ],
        foreign=[TEXTS[0]],
    )


class Hostile(Recorded):
    """Shows the state to pages, and answers commands with texts like those in it."""

    def __init__(self) -> None:
        self.name = uuid.uuid4().hex
        self.runner = AtOnce()
        self.asked: list[ui.Command] = []
        self.state = state()

    def join(self, page: Outbox) -> None:
        """Send a page the state, and all kinds of events with texts."""
        page.put(
            ui.Event.of_greeting(ui.Hello(ui.VERSION, self.name, full=True)),
            ui.Event.of_whole(self.state),
        )
        for text, shown in zip(TEXTS, self.state.components, strict=True):
            error = ui.State.STATE_ERROR
            change = ui.StateChange(1.0, shown.instance, 0, error, error, text)
            page.put(
                ui.Event.of_change(change),
                ui.Event.of_other(change),
                ui.Event.of_reported(ui.Notice(1.0, text, shown.instance, text)),
                *traffic(text),
            )
            page.statistics([ui.Statistics(shown.instance, 1, 2, 3, text, text)])

    def execute(self, page: Outbox, message: ui.ClientMessage) -> None:
        """Answer a command; what would change the system is refused."""
        result = ui.Result(request=message.request, done=True)
        value: Any = message.asked.value
        self.asked.append(message.asked)
        match message.asked.discriminator:
            case CommandKind.COMMAND_WATCH:
                samples = [sample(each, t) for t in (0.5, 1.0, 1.5) for each in value]
                page.show_more([ui.Event.of_samples(samples)])
            case CommandKind.COMMAND_FITS:
                for i, text in enumerate(TEXTS):
                    name = (text, f"{text} 2")[i % 2]
                    port = ui.PortAddress(component(i, text).instance, name)
                    result.fits.append(ui.Fit(port, ("", f"{text}\n{text}")[i % 2]))
            case CommandKind.COMMAND_OBJECTS:
                for i, text in enumerate(TEXTS):
                    access = ("rw", text)[i % 2]
                    entry = ui.ObjectEntry(
                        _OBJECTS + i, 0, text, text, access, text, text
                    )
                    result.objects.append(entry)
            case CommandKind.COMMAND_SDO_READ:
                result.text = TEXTS[value.index - _OBJECTS]
            case CommandKind.COMMAND_CALL:
                result.reply = _pose(value.interface_name, 1.0)
            case CommandKind.COMMAND_LOOK:
                pass
            case _:
                text = TEXTS[len(self.asked) % len(TEXTS)]
                result.done, result.code = False, text
                result.message, result.hint = text, text
        page.put(ui.Event.of_outcome(result))
