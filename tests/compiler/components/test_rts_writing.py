"""model.System to RtsProfile: the rules of the format, and the round trip."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from rts_rules import broken_rules

from rtgen.compiler.backends.profiles.rts_profile import system_text
from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml, rts_profile
from rtgen.compiler.model import (
    Activation,
    Connection,
    PortReference,
    System,
    SystemComponent,
)

ROOT = Path(__file__).resolve().parents[3]
SYSTEMS = sorted(
    path
    for path in ROOT.glob("specs/*/*.xml")
    if b"RtsProfile" in path.read_bytes()[:2000]
)


def read(path: Path) -> System:
    result = rts_profile.load(path)
    assert result.system is not None
    return result.system


def again(text: str) -> System:
    result = rts_profile.load_bytes(text.encode(), "again.xml")
    assert result.diagnostics == ()
    assert result.system is not None
    return result.system


def plain(system: System) -> System:
    """Return the system without positions, its connectors in the order of the schema."""
    nowhere = Span("", 1, 1, 1, 1)
    by_kind = sorted(system.connections, key=lambda c: c.service)
    return replace(
        system,
        file="",
        components=tuple(replace(c, span=nowhere) for c in system.components),
        connections=tuple(
            replace(c, span=nowhere, properties=tuple(sorted(c.properties)))
            for c in by_kind
        ),
    )


def test_the_reference_build_has_systems() -> None:
    assert len(SYSTEMS) >= 8


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem)
def test_systems_of_the_specs_keep_the_rules(path: Path) -> None:
    assert broken_rules(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem)
def test_a_written_system_keeps_the_rules_and_is_the_same(path: Path) -> None:
    system = read(path)
    text = system_text(system)
    assert broken_rules(text) == []
    written = again(text)
    assert plain(written).components == plain(system).components
    assert written.activation == system.activation
    assert written.properties == system.properties
    for one, other in zip(
        plain(written).connections, plain(system).connections, strict=True
    ):
        assert (one.source, one.target, one.id, one.name) == (
            (other.source, other.target, other.id, other.name)
        )
        assert dict(other.properties).items() <= dict(one.properties).items()
    assert system_text(written) == text


@pytest.mark.sampled(4)
@pytest.mark.parametrize("path", SYSTEMS, ids=lambda p: p.stem)
def test_the_same_in_yaml(path: Path) -> None:
    text = system_text(read(path))
    yaml = profile_yaml.to_yaml(located_xml.parse(text, "s.xml"))
    result = rts_profile.load_bytes(yaml.encode(), "s.yaml")
    assert result.system is not None
    assert plain(result.system) == plain(again(text))


def test_what_a_system_leaves_out_is_written() -> None:
    text = (
        '<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts">'
        '<rts:Components rts:id="RTC:a:b:C:1" rts:instanceName="C0"/>'
        '<rts:Components rts:id="RTC:a:b:D:1" rts:instanceName="D0"/>'
        "<rts:DataPortConnectors>"
        '<rts:sourceDataPort rts:instanceName="C0" rts:portName="x"/>'
        '<rts:targetDataPort rts:instanceName="D0" rts:portName="y"/>'
        "</rts:DataPortConnectors></rts:RtsProfile>"
    )
    result = rts_profile.load_bytes(text.encode(), "left/out.xml")
    assert result.system is not None
    written = system_text(result.system)
    assert broken_rules(written) == []
    assert 'rts:abstract="out"' in written
    assert 'rts:pathUri="localhost/C0.rtc"' in written
    [connection] = again(written).connections
    assert dict(connection.properties)["dataport.subscription_type"] == "flush"


def test_texts_are_escaped_and_conditions_kept() -> None:
    system = read(SYSTEMS[0])
    first, second = system.components[0].instance, system.components[1].instance
    edited = replace(
        system,
        abstract='<&"\n\t>',
        activation=(
            Activation(instance=second, sequence=1, wait_ms=250),
            Activation(instance=first, sequence=2, after=(second,)),
        ),
    )
    text = system_text(edited, header=["a -- b"])
    assert broken_rules(text) == []
    assert again(text).abstract == edited.abstract
    assert again(text).activation == edited.activation


TEXTS = st.text(
    st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff"),
    max_size=12,
)
NAMES = TEXTS.filter(lambda text: bool(text.strip()) and "." not in text)


@st.composite
def systems(draw: st.DrawFn) -> System:
    """Draw a system with everything in the model, its texts as odd as XML allows."""
    span = Span("", 1, 1, 1, 1)
    instances = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    pairs = st.lists(st.tuples(NAMES, TEXTS), max_size=3, unique_by=lambda p: p[0])
    components = [
        SystemComponent(
            instance=instance,
            type="Kind",
            id="RTC:v:c:Kind:1.0.0",
            path_uri="localhost/" + instance,
            span=span,
            rate=draw(st.none() | st.floats(0.001, 1e6)),
            active_set=draw(NAMES),
            configuration=tuple(
                (name, tuple(draw(pairs)))
                for name in draw(st.lists(NAMES, max_size=2, unique=True))
            ),
            location=draw(st.tuples(*[st.integers(-(10**6), 10**6)] * 4)),
            required=draw(st.booleans()),
        )
        for instance in instances
    ]
    ends = st.builds(
        lambda instance, port: PortReference(instance=instance, port=port),
        st.sampled_from(instances),
        NAMES,
    )
    joined = draw(
        st.lists(st.tuples(ends, ends), max_size=4, unique_by=lambda pair: str(pair))
    )
    connections = [
        Connection(
            id=f"c{number}",
            name=f"{source} to {target}",
            source=source,
            target=target,
            service=draw(st.booleans()),
            span=span,
            properties=tuple(draw(pairs)),
        )
        for number, (source, target) in enumerate(joined)
    ]
    order = draw(st.permutations(instances))
    steps = [
        Activation(instance=instance, sequence=number, wait_ms=draw(st.integers(0, 99)))
        for number, instance in enumerate(order, 1)
    ]
    return System(
        name="Name",
        id="RTSystem:v:Name:1.0.0",
        file="",
        abstract=draw(NAMES),
        components=tuple(components),
        connections=tuple(connections),
        activation=tuple(steps),
        properties=tuple(draw(pairs)),
    )


@pytest.mark.sampled(0)
@given(systems())
def test_any_system_is_the_same_when_it_is_read_again(system: System) -> None:
    text = system_text(system)
    assert broken_rules(text) == []
    written = plain(again(text))
    for name in ("id", "abstract", "components", "activation", "properties"):
        assert getattr(written, name) == getattr(plain(system), name)
    for one, other in zip(written.connections, plain(system).connections, strict=True):
        assert replace(one, properties=()) == replace(other, properties=())
        assert dict(other.properties).items() <= dict(one.properties).items()
