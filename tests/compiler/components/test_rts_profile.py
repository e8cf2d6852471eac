"""RtsProfile to model.System: accepted and refused files, with positions."""

import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.frontends.kit import xml_rules
from rtgen.compiler.frontends.profiles import rules
from rtgen.compiler.frontends.profiles.rts_profile import (
    SystemResult,
    load,
    load_bytes,
)
from rtgen.compiler.model import PortReference, System

GOLDEN = Path(__file__).resolve().parents[4] / "shared/golden/rtc_profiles/rts"

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:Lab:Drive:1.0.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext">
"""


def component(instance: str, children: str = "", more: str = "") -> str:
    id_ = f"RTC:Lab:Move:{instance[:-1]}:1.0.0"
    return (
        f'<rts:Components rts:id="{id_}" rts:instanceName="{instance}" {more}>\n'
        f"{children}</rts:Components>\n"
    )


def end(tag: str, instance: str, port: str) -> str:
    return f'<rts:{tag} rts:instanceName="{instance}" rts:portName="{port}"/>\n'


def connector(source: str, target: str, more: str = "", children: str = "") -> str:
    return (
        f"<rts:DataPortConnectors {more}>\n"
        f"{end('sourceDataPort', *source.split('/'))}{end('targetDataPort', *target.split('/'))}"
        f"{children}</rts:DataPortConnectors>\n"
    )


def target(instance: str, sequence: str = "1", condition: str = "") -> str:
    return (
        f'<rts:targets rts:sequence="{sequence}">'
        f'<rts:TargetComponent rts:instanceName="{instance}" rts:id="0"/>{condition}'
        "</rts:targets>\n"
    )


def after(*instances: str) -> str:
    inner = "".join(
        f'<rts:PrecedingComponents rts:instanceName="{i}"/>' for i in instances
    )
    return f"<rts:Preceding>{inner}</rts:Preceding>"


def read(*parts: str) -> SystemResult:
    return load_bytes((HEAD + "".join(parts) + "</rts:RtsProfile>\n").encode(), "s.xml")


def system_of(*parts: str) -> System:
    result = read(*parts)
    assert result.diagnostics == ()
    assert result.system is not None
    return result.system


def finding(*parts: str) -> Diagnostic:
    result = read(*parts)
    assert result.system is None
    assert len(result.diagnostics) == 1
    return result.diagnostics[0]


def text_at(result: SystemResult, diagnostic: Diagnostic) -> str:
    assert diagnostic.span is not None
    line = result.sources["s.xml"].splitlines()[diagnostic.span.line - 1]
    return line[diagnostic.span.column - 1 : diagnostic.span.end_column - 1]


def test_component_with_everything() -> None:
    children = (
        '<rts:ConfigurationSets rts:id="default"><rts:ConfigurationData rts:name="a" rts:data="1"/>'
        '</rts:ConfigurationSets><rts:ExecutionContexts rts:id="0" rts:rate="50.0"/>'
        '<rtsExt:Location rtsExt:x="4" rtsExt:y="-2" rtsExt:width="-1" rtsExt:height="9"/>'
    )
    more = 'rts:activeConfigurationSet="fast" rts:isRequired="false" rts:pathUri="localhost/A0.rtc"'
    (found,) = system_of(component("A0", children, more)).components
    assert (found.instance, found.type, found.id) == ("A0", "A", "RTC:Lab:Move:A:1.0.0")
    assert (found.rate, found.active_set, found.required) == (50.0, "fast", False)
    assert found.path_uri == "localhost/A0.rtc"
    assert found.configuration == (("default", (("a", "1"),)),)
    assert found.location == (4, -2, -1, 9)


def test_missing_abstract_rate_and_location_are_fine() -> None:
    system = system_of(component("A0"))
    assert (system.name, system.abstract) == ("Drive", "")
    assert (system.components[0].rate, system.components[0].location) == (None, None)


def test_names_are_bound_by_namespace_not_by_prefix() -> None:
    text = HEAD.replace("rts:", "q:").replace("xmlns:rts=", "xmlns:q=")
    text += component("A0").replace("rts:", "q:") + "</q:RtsProfile>"
    system = load_bytes(text.encode(), "s.xml").system
    assert system is not None
    assert system.components[0].instance == "A0"


def test_id_with_dots() -> None:
    text = component("A0").replace("RTC:Lab:Move:A:1.0.0", "RTC:org.lab.Move.A:1.0.0")
    assert system_of(text).components[0].type == "A"


def test_connector_attributes_become_properties_and_properties_win() -> None:
    more = (
        'rts:name="c" rts:dataType="IDL:RTC/TimedLong:1.0" rts:interfaceType="corba_cdr" '
        'rts:dataflowType="push" rts:subscriptionType="flush" rts:pushInterval="5.0"'
    )
    children = (
        '<rtsExt:Properties rtsExt:name="dataport.subscription_type" rtsExt:value="new"/>'
        '<rtsExt:Properties rtsExt:name="dataport.buffer.length" rtsExt:value="1024"/>'
        '<rtsExt:Properties rtsExt:name="dataport.corba_cdr.inport_ior" rtsExt:value="IOR:0"/>'
    )
    system = system_of(
        component("A0"), component("B0"), connector("A0/x", "B0/y", more, children)
    )
    (connection,) = system.connections
    assert connection.name == "c"
    assert not connection.service
    assert dict(connection.properties) == {
        "dataport.data_type": "IDL:RTC/TimedLong:1.0",
        "dataport.interface_type": "corba_cdr",
        "dataport.dataflow_type": "push",
        "dataport.subscription_type": "new",
        "dataport.buffer.length": "1024",
    }


@pytest.mark.parametrize(
    ("written", "port"),
    [("x", "x"), ("A0.x", "x"), (".positon", ".positon"), ("A0..positon", ".positon")],
)
def test_the_instance_prefix_is_stripped_once(written: str, port: str) -> None:
    system = system_of(
        component("A0"), component("B0"), connector(f"A0/{written}", "B0/y")
    )
    assert system.connections[0].source == PortReference(instance="A0", port=port)
    assert system.connections[0].name == f"A0.{port}_B0.y"


def test_service_connector() -> None:
    text = connector("A0/s", "B0/s").replace("DataPort", "ServicePort")
    assert system_of(component("A0"), component("B0"), text).connections[0].service


def order(*parts: str) -> list[tuple[str, int]]:
    components = "".join(map(component, ("A0", "B0", "C0")))
    system = system_of(components, "<rts:Activation>", *parts, "</rts:Activation>")
    return [(step.instance, step.wait_ms) for step in system.activation]


def test_activation_by_sequence_and_waiting_time() -> None:
    wait = '<rts:WaitTime rts:waitTime="250"/>'
    steps = order(target("C0", "3"), target("B0", "1", wait), target("A0", "2"))
    assert steps == [("B0", 250), ("A0", 0), ("C0", 0)]


def test_activation_waits_for_those_that_precede() -> None:
    steps = order(
        target("A0", "1", after("C0")),
        target("B0", "2"),
        target("C0", "3", after("B0")),
    )
    assert steps == [("B0", 0), ("C0", 0), ("A0", 0)]


def test_condition_before_the_target() -> None:
    text = (
        '<rts:targets rts:sequence="1"><rts:WaitTime rts:waitTime="7"/>'
        '<rts:TargetComponent rts:instanceName="A0"/></rts:targets>'
    )
    assert order(text) == [("A0", 7)]


def test_without_activation_the_required_ones_go_first() -> None:
    optional = component("A0", more='rts:isRequired="false"')
    system = system_of(
        optional, component("B0", more='rts:isRequired="1"'), component("C0")
    )
    assert [step.instance for step in system.activation] == ["B0", "C0", "A0"]


A0, B0 = component("A0"), component("B0")


@pytest.mark.parametrize(
    ("parts", "code", "place"),
    [
        ((A0, A0), "RTC0512", "A0"),
        ((A0, connector("A0/x", "Z0/y")), "RTC0513", "Z0"),
        ((A0, f"<rts:Activation>{target('Q0')}</rts:Activation>"), "RTC0513", "Q0"),
        (
            (A0, f"<rts:Activation>{target('A0', '1', after('Q0'))}</rts:Activation>"),
            "RTC0513",
            "Q0",
        ),
        (
            (A0, f"<rts:Activation>{target('A0', '1', after('A0'))}</rts:Activation>"),
            "RTC0516",
            "rts:Activation",
        ),
        ((A0, f"<rts:Activation>{target('A0', 'two')}</rts:Activation>"), "RTC0515", "two"),
        ((component("A0", '<rts:ExecutionContexts rts:rate="-5"/>'),), "RTC0515", "-5"),
        ((component("A0", '<rts:ExecutionContexts rts:rate="nan"/>'),), "RTC0515", "nan"),
        ((component("A0", '<rtsExt:Location rtsExt:x="1.5"/>'),), "RTC0515", "1.5"),
        ((A0.replace("rts:instanceName", "instanceName"),), "RTC0511", "A0"),
        ((A0.replace("RTC:Lab:Move:A:1.0.0", "A"),), "RTC0517", "A"),
        (("<rts:Components/>",), "RTC0511", "rts:Components"),
        (
            (A0, f"<rts:DataPortConnectors>{end('sourceDataPort', 'A0', 'x')}"
            "</rts:DataPortConnectors>"),
            "RTC0514",
            "rts:DataPortConnectors",
        ),
        (("<!-- --><rts:Components></rts:Component>",), "RTC0501", None),
    ],
)  # fmt: skip
def test_errors_with_their_places(
    parts: tuple[str, ...], code: str, place: str | None
) -> None:
    result = read(*parts)
    assert result.system is None
    assert {d.code for d in result.diagnostics} == {code}
    if place is not None:
        assert text_at(result, result.diagnostics[0]) == place


def test_warnings_leave_the_system() -> None:
    one = connector("A0/x", "B0/y")
    other = connector("A0/x", "B0/z").replace(
        'rts:instanceName="A0"',
        'rts:instanceName="A0" rts:componentId="RTC:Else:Move:A:1.0.0"',
    )
    result = read(A0, B0, one, other)
    assert result.system is not None
    assert [d.code for d in result.diagnostics] == ["RTC0518"]


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "RTC0501"),
        (b"junk", "RTC0501"),
        (bytes(range(256)), "RTC0503"),
        ("<a>\u00e9</a>".encode("latin-1"), "RTC0503"),
        (b'<?xml version="1.0" encoding="martian"?><a/>', "RTC0503"),
        (
            b'<!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>',
            "RTC0502",
        ),
        (b"<a>" * 200 + b"</a>" * 200, "RTC0504"),
        (b"<RtsProfile/>", "RTC0510"),
        (b"<a><b></a>", "RTC0501"),
        (b"<a x=1/>", "RTC0501"),
        (b"<p:a/>", "RTC0501"),
    ],
)
def test_no_profile_at_all(data: bytes, code: str) -> None:
    result = load_bytes(data, "s.xml")
    assert result.system is None
    assert [d.code for d in result.diagnostics] == [code]
    assert result.diagnostics[0].span is not None


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "shift_jis", "iso-8859-1"])
def test_encodings(encoding: str) -> None:
    instance = "ロボット0" if encoding != "iso-8859-1" else "Müller0"
    declared = encoding.removesuffix("-sig")
    text = HEAD.replace("UTF-8", declared) + component(instance) + "</rts:RtsProfile>"
    system = load_bytes(text.encode(encoding), "s.xml").system
    assert system is not None
    assert system.components[0].instance == instance


def test_missing_file_and_folder(tmp_path: Path) -> None:
    for path in (tmp_path / "none.xml", tmp_path, Path("a\0b")):
        result = load(path)
        assert [d.code for d in result.diagnostics] == ["RTC0505"]


@given(st.binary(max_size=200))
def test_junk_never_raises(data: bytes) -> None:
    assert load_bytes(data, "s.xml").diagnostics


@given(st.integers(0, 10**6))
def test_damaged_profiles_never_raise(seed: int) -> None:
    chance = random.Random(seed)
    text = HEAD + A0 + B0 + connector("A0/x", "B0/y") + "</rts:RtsProfile>"
    data = bytearray(text.encode())
    for _ in range(chance.randint(1, 4)):
        start = chance.randrange(len(data))
        data[start : start + chance.randint(0, 20)] = chance.randbytes(
            chance.randint(0, 3)
        )
    result = load_bytes(bytes(data), "s.xml")
    assert {d.code for d in result.diagnostics} <= {
        rule.code for rule in (*rules.RULES, *xml_rules.RULES)
    }


def test_real_profiles() -> None:
    if not GOLDEN.is_dir():
        pytest.skip(f"no real profiles at {GOLDEN}")
    for path in sorted(GOLDEN.glob("*.xml")):
        result = load(path)
        assert result.diagnostics == ()
        assert result.system is not None
        assert result.system.components
