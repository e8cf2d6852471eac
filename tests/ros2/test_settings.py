"""`[ros2]` of rtgen.toml and `rtgen run --ros2`: accepted and refused settings."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run as rtgen
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.project import Project, load
from rtgen.facts.ros_qos import (
    PROFILES,
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
)

SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:me:plain:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts">
  <rts:Components rts:id="RTC:me:Demo:Plain:1.0.0" rts:instanceName="P0"
      rts:pathUri="localhost/P0.rtc" rts:compositeType="None" rts:isRequired="true"/>
</rts:RtsProfile>
"""
MODULE = """
from rtgen.runtime import Component, ComponentProfile, idl
from rtgen.runtime.cdr import Aggregated


class Own(Aggregated):
    _descriptor_ = idl.struct("lab::Own", x=idl.DOUBLE)

    x: float = 0.0


class Plain(Component):
    profile = ComponentProfile("Plain", rate=10.0)

    def __init__(self, instance_name=None):
        super().__init__(instance_name)
        self.add_out_port("own", Own)
"""


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(text: str) -> Project:
    Path("rtgen.toml").write_text(text)
    return load()


def test_a_whole_section() -> None:
    settings = written(
        '[ros2]\nnode = "n"\nnamespace = "a/b"\ndomain = 7\ninterface = "eth0"\n'
        'zenoh = "z.json5"\n[ros2.topics]\n"A0.out" = "x"\n'
        '"A0.in" = { topic = "/y", qos = "map" }\n'
    ).ros2
    assert (settings.node, settings.namespace, settings.domain) == ("n", "/a/b", 7)
    assert (settings.interface, settings.zenoh) == ("eth0", "z.json5")
    first, second = settings.topics
    assert (first.instance, first.port, first.topic) == ("A0", "out", "x")
    assert first.profile == PROFILES["default"]
    assert (second.topic, second.profile) == ("/y", PROFILES["map"])
    assert (first.span.line, second.span.line) == (8, 9)


WRONG = {
    '[ros2]\nnode = "a b"': "'node' in [ros2] must be a name of ROS 2, which consists of words",
    '[ros2]\nnamespace = "a__b"': "has no __",
    "[ros2]\ndomain = 233": "must be a number from 0 to 232",
    "[ros2]\nnodes = 1": "unknown key 'nodes' in [ros2]",
    '[ros2.topics]\n"A0" = "x"': "holds 'A0', which is not INSTANCE.PORT",
    '[ros2.actions]\n"A0.p.o" = "x"': "holds 'A0.p.o', which is not INSTANCE.PORT",
    '[ros2.actions]\n"A0.p" = "x y"': "gives 'A0.p' the action 'x y'; a name of ROS 2",
    '[ros2.services]\n"A0.p" = "x"': "holds 'A0.p', which is not INSTANCE.PORT.OPERATION",
    '[ros2.services]\n"A0.p.o" = 1': "holds 'A0.p.o', which must be 'NAME'",
    '[ros2.services]\n"A0.p.o" = "x y"': "gives 'A0.p.o' the service 'x y'; a name of ROS 2",
    '[ros2.topics]\n"A0.p" = 1': "holds 'A0.p', which must be 'NAME'",
    '[ros2.topics]\n"A0.p" = "x y"': "gives 'A0.p' the topic 'x y'; a name of ROS 2",
    '[ros2.topics]\n"A0.p" = {topic="x", marshaling_type="Float32"}': "is not ros2:PACKAGE/TYPE",
    '[ros2.topics]\n"A0.p" = {topic="x", qos="best"}': "gives 'A0.p' the qos 'best'; known:",
    '[ros2.topics]\n"A0.p" = {topic="x", qos=1}': "gives 'A0.p' the qos 1; known:",
    '[ros2.topics]\n"A0.p" = {topic="x", deep=1}': "gives 'A0.p' the unknown key 'deep'",
    '[ros2.topics]\n"A0.p" = {topic="x", depth=0}': "the depth 0; it must be a number",
    '[ros2.topics]\n"A0.p" = {topic="x", depth=true}': "the depth True; it must be a number",
    '[ros2.topics]\n"A0.p" = {topic="x", deadline=0}': "the deadline 0; it must be a time",
    '[ros2.topics]\n"A0.p" = {topic="x", lifespan="1 s"}': "the lifespan '1 s'; it must be a",
    '[ros2.topics]\n"A0.p" = {topic="x", lease=-0.5}': "the lease -0.5; it must be a time",
    '[ros2.topics]\n"A0.p" = {topic="x", history="all"}': "known: keep_last, keep_all",
    '[ros2.topics]\n"A0.p" = {topic="x", reliability="RELIABLE"}': "known: reliable, best_effort",
    '[ros2.topics]\n"A0.p" = {topic="x", durability="persistent"}': "known: transient_local, vol",
    '[ros2.topics]\n"A0.p" = {topic="x", liveliness="manual"}': "known: automatic, manual_by_",
    '[ros2.topics]\n"A0.p" = {topic="x", history="keep_all", depth=5}': "a depth without effect",
}
HINTS = {
    "depht = 1": "did you mean 'depth'?",
    'qos = "sensor"': "did you mean 'sensor_data'?",
    'reliability = "RELIABLE"': "did you mean 'reliable'?",
    'durability = "transient-local"': "did you mean 'transient_local'?",
    'history = "keep_all", depth = 5': "remove one of them",
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_sections_have_a_place(text: str) -> None:
    with pytest.raises(InputError) as error:
        written(text)
    [finding] = error.value.diagnostics
    assert WRONG[text] in finding.message
    assert finding.span is not None
    assert finding.span.line == 2


@pytest.mark.parametrize("words", HINTS)
def test_hints_of_qos(words: str) -> None:
    with pytest.raises(InputError) as error:
        written(f'[ros2.topics]\n"A0.p" = {{ topic = "x", {words} }}\n')
    [finding] = error.value.diagnostics
    assert finding.hint == HINTS[words]


def test_qos_of_a_topic() -> None:
    [entry] = written(
        '[ros2.topics]\n"A0.p" = { topic = "x", qos = "sensor_data", depth = 7, '
        'history = "keep_last", reliability = "reliable", durability = "transient_local", '
        'deadline = 0.1, lifespan = 2, liveliness = "manual_by_topic", lease = 1.5 }\n'
    ).ros2.topics
    assert entry.profile == Profile(
        *(7, Reliability.RELIABLE, Durability.TRANSIENT_LOCAL, History.KEEP_LAST),
        *(10**8, 2 * 10**9, Liveliness.MANUAL_BY_TOPIC, 1_500_000_000),
    )


@pytest.fixture
def system(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    name = f"plain_{tmp_path.name}"
    Path(f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    Path("s.xml").write_text(SYSTEM)
    return f'[components]\nPlain = "{name}:Plain"\n'


REFUSED = {
    "\n[ros2]\nmanaged_nodes = false": (["--clock", "real"], "no port is a topic"),
    '"P0.own" = "x"': (
        ["--clock", "real"],
        "carries lab::Own, which is not a message of ROS 2",
    ),
    '"P1.own" = "x"': (["--clock", "real"], "there is no component 'P1'; known: P0"),
    '"P0.other" = "x"': (
        ["--clock", "real"],
        "P0 has no data port 'other'; known: own",
    ),
    '"P0.own" = "y"': ([], "--ros2 needs --clock real, --clock ros"),
}


@pytest.mark.parametrize("entry", REFUSED)
def test_refused_before_the_start(
    entry: str, system: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("rtgen.toml").write_text(f"{system}[ros2.topics]\n{entry}\n")
    options, message = REFUSED[entry]
    assert rtgen(["run", "s.xml", "--ros2", "dds", "--until", "1", *options]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("kind", "setting", "message"),
    [
        (
            "dds",
            'interface = "nowhere0"\ndomain = 92',
            "[ros2] interface: Cyclone DDS does not start with 'nowhere0'\n  hint: the name",
        ),
        ("zenoh", 'zenoh = "none.json5"', "none.json5 cannot be read: "),
    ],
)
def test_networks_that_cannot_be_opened(
    system: str,
    kind: str,
    setting: str,
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip({"dds": "cyclonedds", "zenoh": "zenoh"}[kind])
    Path("rtgen.toml").write_text(f"{system}[ros2]\n{setting}\n")
    command = ["run", "s.xml", "--ros2", kind, "--until", "1", "--clock", "real"]
    assert rtgen(command) == 3
    text = capsys.readouterr().err
    assert message in text
    assert ".rs:" not in text


def test_domain_of_the_environment(
    system: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("rtgen.toml").write_text(f'{system}[ros2.topics]\n"P0.own" = "x"\n')
    monkeypatch.setenv("ROS_DOMAIN_ID", "many")
    command = ["run", "s.xml", "--ros2", "dds", "--until", "1", "--clock", "real"]
    assert rtgen(command) == 3
    assert "ROS_DOMAIN_ID is 'many', no number from 0 to 232" in capsys.readouterr().err
