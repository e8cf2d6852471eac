"""Functions of boards as services of ROS 2: interface files, hashes, and the values of calls."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest
from boards import MOTOR, SERVER, joined
from random_signatures import SPAN, Sample, plain, sample
from ros2_peers import DISTRIBUTIONS, installation
from seeds import cases

from rtgen.compiler.backends import Options
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.layouts.ros_types import type_hash
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import lowered
from rtgen.compiler.lowering.tecs.boards import BoardPackage
from rtgen.compiler.lowering.tecs.options import RtcOptions
from rtgen.compiler.lowering.tecs.plan import RtcJoin, TecsPackage
from rtgen.compiler.lowering.tecs.plan import Service as Planned
from rtgen.compiler.model import Model, Struct
from rtgen.compiler.model.tecs import Cell, Join, PluginArgument, Through
from rtgen.ros2.boards.interfaces import Interfaces, interfaces, of_board
from rtgen.ros2.boards.values import to_board, to_message
from rtgen.ros2.rosidl import load as load_ros
from rtgen.runtime.opaque_rpc import (
    E_OBJ,
    E_RPC,
    ERCD,
    ChannelError,
    ExchangeChannel,
    PacketServer,
    make_tdr,
)
from rtgen.runtime.opaque_rpc.values import is_rpc_error
from rtgen.runtime.ros2.types import decoded, encoded
from rtgen.tools.recording.schema_types import message_classes
from rtgen.tools.rpc.codecs import Service
from rtgen.tools.running.ros2_boards import answering

OPTIONS = Options("robots", "nodes", "0", ros_boards="/lab")
LIMIT = 1 << 20


def of_text(folder: Path, text: str, name: str = "board.cdl") -> list[Interfaces]:
    (folder / name).write_text(text)
    read = load([folder / name], root=folder)
    assert not has_errors(read.diagnostics), read.diagnostics
    made = lowered(read.model, Settings())
    assert not has_errors(made.diagnostics), made.diagnostics
    return interfaces(made.model, "robots")


def said(findings: tuple[Diagnostic, ...]) -> list[tuple[str, int, str]]:
    return [(f.code, f.span.line if f.span else 0, f.message) for f in findings]


def test_names_types_and_comments(tmp_path: Path) -> None:
    text = """\
struct tagAt { int16_t levelNow; /**< Where [m]. */ uint8_t raw[4]; char_t c; };
signature sArm {
    /** Moves it. */
    ER moveTo( [in] int8_t percent, [in,size_is(n)] const struct tagAt *path, [in] int32_t n,
               [out,nullable] struct tagAt *message, [out,string(9)] char_t *class );
    void pause( void );
    [oneway] void stop( [in] long_t why );
};
"""
    [made] = of_text(tmp_path, joined(text, "sArm"))
    assert not made.findings
    assert [s.name for s in made.services] == [
        *("board/move_to", "board/pause", "board/stop")
    ]
    assert made.texts == {
        "robots_board/msg/TagAt.msg": (
            "int16 level_now  # Where [m].\nuint8[4] raw\nuint8 c\n"
        ),
        "robots_board/srv/ArmMoveTo.srv": """\
# Moves it.

int8 percent
robots_board/TagAt[] path
int32 n
---
bool success  # The board was called, and returned no error.
string message  # Why not.
int32 return_value
robots_board/TagAt[<=1] message_value
string class_value
""",
        "robots_board/srv/ArmPause.srv": """\
# void pause(void)

---
bool success  # The board was called, and returned no error.
string message  # Why not.
""",
        "robots_board/srv/ArmStop.srv": """\
# [oneway] void stop([in] long_t why)

int32 why
---
bool success  # The board was called, and returned no error.
string message  # Why not.
""",
    }


def test_several_joins_have_the_names_of_their_cells(tmp_path: Path) -> None:
    text = joined(SERVER + SERVER.replace("sServer", "sOther"), "sServer", "sOther")
    [made] = of_text(tmp_path, text)
    names = [service.name for service in made.services]
    assert names == [
        f"board/{cell}/{function}"
        for cell in ("server0", "server1")
        for function in ("func1", "func2", "func3")
    ]
    assert len({service.interface for service in made.services}) == 6


def test_what_ros_2_cannot_express_is_located(tmp_path: Path) -> None:
    text = """\
struct tagGrid { int8_t cells[2][3]; };
signature sBad {
    ER first( [in] const int32_t grid[2][3] );
    ER second( [in] const struct tagGrid *grid );
    ER third( [in,count_is(n),nullable] const int32_t *some, [in] int32_t n );
    ER fourth( [in] int32_t aB, [in] int32_t a_b );
    ER setIt( void );
    ER set_it( void );
    ER good( [in] int32_t a, [out] int32_t *b );
};
"""
    [made] = of_text(tmp_path, joined(text, "sBad"))
    nested = "sequences and arrays in each other"
    assert said(made.findings) == [
        (
            "ROS0120",
            3,
            f"sBad.first has no service of ROS 2, which does not have {nested}",
        ),
        (
            "ROS0120",
            4,
            f"sBad.second has no service of ROS 2, which does not have {nested}",
        ),
        (
            *("ROS0120", 5),
            "sBad.third has no service of ROS 2, which does not have sequences and arrays that "
            "may be NULL",
        ),
        (
            *("ROS0120", 6),
            "sBad.fourth has no service of ROS 2, which does not have the name a_b beside the "
            "others",
        ),
        (
            *("ROS0120", 8),
            "sBad.set_it has no service of ROS 2, which does not have a second BadSetIt",
        ),
    ]
    assert all(finding.hint for finding in made.findings)
    assert [s.name for s in made.services] == ["board/set_it", "board/good"]


def test_two_functions_of_one_name_are_located(tmp_path: Path) -> None:
    """Two files of one name in different folders are one prefix."""
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        name = SERVER.replace("sServer", f"sServer{folder}")
        (tmp_path / folder / "board.cdl").write_text(joined(name, f"sServer{folder}"))
    files = [tmp_path / folder / "board.cdl" for folder in ("a", "b")]
    model = lowered(load(files, root=tmp_path).model, Settings()).model
    first, second = interfaces(model, "robots")
    assert len(first.services) == 3
    assert not second.services
    assert [f.code for f in second.findings] == ["ROS0121"] * 3
    finding = second.findings[0]
    assert finding.message.endswith("would both be the service board/func1")
    assert finding.related[0].span.file.endswith("a/board.cdl")


def board_of(found: Sample) -> BoardPackage:
    """Return the package of a board with a drawn signature."""
    planned = Planned(found.signature, "Random", "random", RtcOptions())
    end = Join(
        port="cRandom",
        index=None,
        target=("Random",),
        target_port="eRandom",
        target_index=None,
        signature=found.signature.name,
        span=SPAN,
    )
    cell = Cell(name=("Client",), file="random.cdl", span=SPAN, celltype=("tClient",))
    through = Through(plugin="RTCPlugin", argument=PluginArgument((), SPAN), span=SPAN)
    join = RtcJoin(0, cell, end, through, planned, planned.options)
    plan = TecsPackage(found.unit, "random", (), (planned,), (join,))
    layout = layout_of(found.unit, found.signature)
    side: Any = None
    return BoardPackage(
        name="tecs.random",
        model=Model(),
        sources=(),
        plan=plan,
        side=side,
        layouts=(layout,),
    )


def test_hashes_of_drawn_signatures() -> None:
    """The hashes of messages equal those of rosbags, which reads the files by itself."""
    typesys = pytest.importorskip("rosbags.typesys")
    compared = 0
    for number in cases(100, always=20):
        made = of_board(board_of(sample(Random(number))), "robots")
        store = typesys.get_typestore(typesys.Stores.EMPTY)
        parts = {}
        for name, text in made.texts.items():
            path, _, kind = name.partition(".")
            if kind == "msg":
                parts[path] = text
            else:
                request, response = text.split("---\n")
                parts |= {f"{path}_Request": request, f"{path}_Response": response}
        for name, text in parts.items():
            whole = (
                text
                if _has_fields(text)
                else "uint8 structure_needs_at_least_one_member\n"
            )
            read = typesys.get_types_from_msg(whole, name)
            # It knows messages alone, and says so in the names of others.
            store.register(
                {n.replace("/srv/msg/", "/srv/"): d for n, d in read.items()}
            )
        for name in parts:
            struct = made.model.find(tuple(name.split("/")))
            assert isinstance(struct, Struct)
            assert type_hash(made.model, struct) == store.hash_rihs01(name), name
            compared += 1
    assert compared > 20


@pytest.mark.nightly
@pytest.mark.peer
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_hashes_of_rosidl(distribution: str, tmp_path: Path) -> None:
    """The hashes of services, too, equal those that rosidl computes of the files."""
    made = [
        of_board(board_of(sample(Random(number))), f"robots{place}")
        for place, number in enumerate(cases(30, always=4))
    ]
    made = [each for each in made if each.texts]
    for each in made:
        for name, text in each.texts.items():
            file = tmp_path / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
    packages = [next(iter(each.texts)).partition("/")[0] for each in made]
    oracle = Path(__file__).parents[2] / "ros2" / "rosidl_hashes.py"
    output = installation(distribution).output(oracle, str(tmp_path), *packages)
    hashes = json.loads(output)["hashes"]
    own = {name: each.hashes[name] for each in made for name in each.hashes}
    assert {name: hashes[name] for name in own} == own
    assert sum("/srv/" in name for name in own) >= 4


def _has_fields(text: str) -> bool:
    return any(line and not line.startswith("#") for line in text.splitlines())


def answer_by(taken: list[Any], answers: dict[str, Any], name: str, *given: Any) -> Any:
    taken.append(given)
    return answers[name]


@pytest.mark.sampled(0)
def test_values_of_drawn_calls() -> None:
    """A board gets the arguments that a request has, and a response has what it returns."""
    made_calls = 0
    for number in cases(150, always=30):
        random = Random(number)
        found = sample(random)
        made = of_board(board_of(found), "robots")
        service = Service(found.unit, found.signature, make_tdr("network"), limit=LIMIT)
        messages = message_classes(made.model)
        structs = {
            tag: (getattr(service.types, tag[0]), messages[name])
            for tag, name in made.messages.items()
        }
        taken: list[Any] = []
        answers: dict[str, Any] = {}

        handlers = {
            service.codec.request_head(f.id): f.handler(
                partial(answer_by, taken, answers, f.name)
            )
            for f in service.codec.functions.values()
        }
        channel = ExchangeChannel(PacketServer(SimpleNamespace(handlers=handlers)))
        proxy = SimpleNamespace(codec=service.codec, channel=channel)
        port: Any = SimpleNamespace(
            exists=True, owner="Board0", servant=SimpleNamespace(_proxy=proxy)
        )
        for each in made.services:
            function = service.functions[each.layout.function.name]
            layout = each.layout
            call = found.call(random, layout.function, service.types)
            if any(item.asked and not call.args[item.name] for item in layout.outs):
                continue  # a service wants each result
            outs = [call.outs[item.name] for item in layout.outs]
            values = [*([] if layout.is_void else [call.returned]), *outs]
            answers[layout.function.name] = (
                None if not values else values[0] if len(values) == 1 else tuple(values)
            )
            request = messages[f"{each.interface}_Request"]
            response = messages[f"{each.interface}_Response"]
            [method] = [
                n for n, f in service.codec.functions.items() if f.name == function.name
            ]
            answer = answering(each, port, method, structs, response)
            sent = request(
                **{
                    field: to_message(item, structs)(call.args[item.name])
                    for item, field in each.arguments
                }
            )
            got = decoded(response, encoded(answer(decoded(request, encoded(sent)))))
            given = [call.args[item.name] for item in layout.arguments]
            assert plain(list(taken.pop())) == plain(given)
            made_calls += 1
            if function.oneway:
                assert got.success
                continue
            code = call.returned if is_code(layout) else 0
            assert got.success == (code >= 0)
            assert bool(got.message) == (code < 0)
            if layout.leaves_out and is_rpc_error(call.returned):
                continue
            for (item, field), value in zip(each.results, values, strict=True):
                assert plain(to_board(item, structs)(getattr(got, field))) == plain(
                    value
                )
    assert made_calls > 30


def is_code(layout: Any) -> bool:
    return str(layout.function.returns) in ("ER", "ER_INT")


def test_a_board_that_is_not_there(tmp_path: Path) -> None:
    """Its error is in the response, for functions that return a code and for others."""
    text = "signature sLamp { ER dim( [in] uint8_t p ); uint8_t get( void ); void off( void ); };"
    [made] = of_text(tmp_path, joined(text, "sLamp"))
    unit = made.board.plan.unit
    service = Service(unit, made.board.plan.services[0].signature, make_tdr("network"))
    messages = message_classes(made.model)

    def refused(_: bytes) -> bytes:
        raise ChannelError(E_OBJ, "127.0.0.1:8931: Connection refused")

    proxy = SimpleNamespace(codec=service.codec, channel=ExchangeChannel(refused))
    port: Any = SimpleNamespace(
        exists=True, owner="Lamp0", servant=SimpleNamespace(_proxy=proxy)
    )
    for each in made.services:
        name = each.layout.function.name
        request, response = (
            messages[f"{each.interface}_{end}"] for end in ("Request", "Response")
        )
        answer = answering(each, port, name, {}, response)
        got = answer(request())
        assert not got.success
        assert got.message == "127.0.0.1:8931: Connection refused (E_OBJ)"
        if name == "dim":
            assert got.return_value == ERCD(E_RPC, E_OBJ)
        if name == "get":
            assert got.return_value == 0
    port.exists = False
    request = messages["robots_board/srv/LampDim_Request"]
    response = messages["robots_board/srv/LampDim_Response"]
    got = answering(made.services[0], port, "dim", {}, response)(request())
    assert (got.success, got.message) == (False, "Lamp0 is not ACTIVE")
    assert got.return_value == ERCD(E_RPC, E_OBJ)


def test_odd_structs_and_names(tmp_path: Path) -> None:
    """The board with name spaces, words of Python, and arrays in each other."""
    [made] = of_text(tmp_path, joined(MOTOR, "nBoard::sMotor"))
    assert [service.name.rpartition("/")[2] for service in made.services] == [
        *("set", "get", "maybe", "part", "stop", "stop_all", "bytes", "list", "init"),
    ]
    left_out = [f.message.partition(" has no ")[0] for f in made.findings]
    assert left_out == [
        f"nBoard::sMotor.{n}" for n in ("state", "names", "wide", "class")
    ]
    files = []
    for name, text in made.texts.items():
        file = tmp_path / "ros" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        files.append(file)
    read = load_ros(files, root=tmp_path / "ros")
    assert not read.diagnostics
