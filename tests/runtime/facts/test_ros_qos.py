"""QoS of ROS 2: what fits, and its words in rtgen.toml and in properties of connectors."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.facts.connector_properties import stated_data, violation
from rtgen.facts.ros_qos import (
    PROFILES,
    Durability,
    History,
    Liveliness,
    Profile,
    Reliability,
    change,
    misfits,
)
from rtgen.facts.ros_qos_words import (
    KINDS,
    MAX_DEPTH,
    POLICIES,
    TIMES,
    has_idle_depth,
    of_text,
    problems,
    profile_of,
    profiles,
    topic_of,
    value_of,
)
from rtgen.facts.topic_properties import TRANSPORTS

WEAKEST = {
    "reliability": (Reliability.BEST_EFFORT, Reliability.RELIABLE),
    "durability": (
        *(Durability.VOLATILE, Durability.TRANSIENT_LOCAL),
        *(Durability.TRANSIENT, Durability.PERSISTENT),
    ),
    "liveliness": tuple(Liveliness),
    "deadline": (None, 10**9, 10**8),
    "lease": (None, 10**9, 10**8),
}
"""Values of the policies that are offered and requested, as in DDS 1.4, 2.2.3: later is more."""
PAIRS = [
    (policy, offered, requested)
    for policy, values in WEAKEST.items()
    for offered, requested in product(range(len(values)), repeat=2)
]


@pytest.mark.parametrize(("policy", "offered", "requested"), PAIRS)
def test_what_is_offered_has_to_be_at_least_what_is_requested(
    policy: str, offered: int, requested: int
) -> None:
    values = WEAKEST[policy]
    publisher = Profile()._replace(**{policy: values[offered]})
    subscription = Profile()._replace(**{policy: values[requested]})
    # Others fit: the defaults are the same on both sides.
    found = misfits(publisher, subscription)
    assert [each.policy for each in found] == [policy] * (offered < requested)


PROFILE = st.builds(
    Profile,
    depth=st.integers(1, 100),
    reliability=st.sampled_from(Reliability),
    durability=st.sampled_from(Durability),
    history=st.sampled_from(History),
    liveliness=st.sampled_from(Liveliness),
    **dict.fromkeys(TIMES, st.none() | st.integers(1, 10**12)),
)


@given(PROFILE, PROFILE)
def test_the_policies_that_do_not_fit_are_all_and_each_by_itself(
    offered: Profile, requested: Profile
) -> None:
    found = {each.policy for each in misfits(offered, requested)}
    alone = {
        policy
        for policy in WEAKEST
        if misfits(
            Profile()._replace(**{policy: getattr(offered, policy)}),
            Profile()._replace(**{policy: getattr(requested, policy)}),
        )
    }
    # A default is the weakest value, except of a reliability.
    assert found == alone
    if offered == requested:
        assert not found


@given(PROFILE, PROFILE)
def test_the_way_out_makes_the_ends_fit(offered: Profile, requested: Profile) -> None:
    found = misfits(offered, requested)
    taken = {each.policy: getattr(requested, each.policy) for each in found}
    assert not misfits(offered._replace(**taken), requested)
    given_up = {each.policy: getattr(offered, each.policy) for each in found}
    assert not misfits(offered, requested._replace(**given_up))
    for each in found:
        assert each.policy in change(found, writes=True)


@pytest.mark.parametrize("policy", KINDS)
def test_words_of_kinds(policy: str) -> None:
    for kind in KINDS[policy]:
        assert value_of(policy, kind.name.lower()) is kind
        assert of_text(policy, f" {kind.name.lower()} ") is kind
    for wrong in ("", "x", kind.name, 1, None, True, [], {}, 0.5):
        with pytest.raises(ValueError, match=kind.name.lower()):
            value_of(policy, wrong)


@pytest.mark.parametrize("policy", TIMES)
def test_times_are_seconds(policy: str) -> None:
    assert value_of(policy, 0.1) == 10**8
    assert value_of(policy, 2) == 2 * 10**9
    assert value_of(policy, float("inf")) is None
    assert of_text(policy, "0.5") == 5 * 10**8
    assert of_text(policy, "inf") is None
    wrong = (0, -1, 1e-12, float("nan"), float("-inf"), 1e30, "1", "", True, None, [])
    for value in wrong:
        with pytest.raises(ValueError, match="a time in seconds, above 0"):
            value_of(policy, value)
    for text in ("", "x", "0", "-1", "nan", "1e400e"):
        with pytest.raises(ValueError, match="a time in seconds, above 0"):
            of_text(policy, text)


def test_depths_are_bounded() -> None:
    assert value_of("depth", 1) == 1
    assert value_of("depth", MAX_DEPTH) == MAX_DEPTH
    for value in (0, -1, MAX_DEPTH + 1, 1.0, "5", True, None):
        with pytest.raises(ValueError, match="from 1 to"):
            value_of("depth", value)
    for text in ("", "0", "1.5", "9" * 5000, "x"):
        with pytest.raises(ValueError, match="from 1 to"):
            of_text("depth", text)


@pytest.mark.parametrize("name", PROFILES)
def test_a_policy_replaces_that_of_the_profile(name: str) -> None:
    base = value_of("qos", name)
    assert profile_of({"qos": base}) == PROFILES[name]
    stated = {"depth": 7, "deadline": 5, "liveliness": Liveliness.MANUAL_BY_TOPIC}
    assert profile_of({"qos": base, **stated}) == PROFILES[name]._replace(**stated)


def test_what_has_no_effect() -> None:
    every = {"history": History.KEEP_ALL}
    assert not has_idle_depth(every)
    assert has_idle_depth({**every, "depth": 5})
    assert not has_idle_depth({"history": History.KEEP_LAST, "depth": 5})


OWN = {
    "depth": ("7", 7),
    "history": ("keep_all", History.KEEP_ALL),
    "reliability": ("best_effort", Reliability.BEST_EFFORT),
    "durability": ("transient_local", Durability.TRANSIENT_LOCAL),
    "liveliness": ("manual_by_topic", Liveliness.MANUAL_BY_TOPIC),
    "deadline": ("0.25", 250_000_000),
    "lifespan": ("2", 2 * 10**9),
    "lease": ("1.5", 1_500_000_000),
}
IN_PYTHON: dict[str, tuple[dict[str, str], Any]] = {
    "depth": ({"history.depth": "7"}, 7),
    "history": ({"history.kind": "KEEP_ALL_HISTORY_QOS"}, History.KEEP_ALL),
    "reliability": (
        {"reliability.kind": "BEST_EFFORT_RELIABILITY_QOS"},
        Reliability.BEST_EFFORT,
    ),
    "durability": (
        {"durability.kind": "TRANSIENT_LOCAL_DURABILITY_QOS"},
        Durability.TRANSIENT_LOCAL,
    ),
    "liveliness": (
        {"liveliness.kind": "MANUAL_BY_TOPIC_LIVELINESS_QOS"},
        Liveliness.MANUAL_BY_TOPIC,
    ),
    "deadline": (
        {"deadline.period.sec": "0", "deadline.period.nanosec": "250000000"},
        250_000_000,
    ),
    "lifespan": ({"lifespan.duration.sec": "2"}, 2 * 10**9),
    "lease": (
        {
            "liveliness.lease_duration.sec": "1",
            "liveliness.lease_duration.nanosec": "500000000",
        },
        1_500_000_000,
    ),
}
"""The words of OpenRTM-aist-Python's ROS2Transport below `reader_qos` and `writer_qos`."""


def in_cpp(name: str) -> str:
    """Return the word of OpenRTM-aist's FastRTPS transport for one of Python's."""
    if name.startswith("history."):
        return f"topic.historyQos.{name.removeprefix('history.')}"
    return f"qos.{name}".replace(".sec", ".seconds")


@pytest.mark.parametrize("policy", POLICIES)
def test_own_properties_are_for_both_ends(policy: str) -> None:
    text, value = OWN[policy]
    key = f"dataport.ros2.{policy}"
    assert violation(stated_data(), key, text) is None
    assert violation(stated_data(), key, "?") is not None
    expected = Profile()._replace(**{policy: value})
    assert profiles({key: text}) == (expected, expected)


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("transport", TRANSPORTS)
def test_words_of_the_transports_in_python(transport: str, policy: str) -> None:
    words, value = IN_PYTHON[policy]
    expected = Profile()._replace(**{policy: value})
    for node, place in (("writer_qos", 0), ("reader_qos", 1)):
        stated = {f"dataport.{transport}.{node}.{k}": t for k, t in words.items()}
        assert [violation(stated_data(), k, t) for k, t in stated.items()] == [
            None
        ] * len(words)
        both = [Profile(), Profile()]
        both[place] = expected
        assert list(profiles(stated)) == both
        for key in stated:
            assert violation(stated_data(), key, "?") is not None


@pytest.mark.parametrize("policy", POLICIES)
def test_words_of_the_transport_in_cpp(policy: str) -> None:
    words, value = IN_PYTHON[policy]
    expected = Profile()._replace(**{policy: value})
    for node, place in (("publisher", 0), ("subscriber", 1)):
        at = f"dataport.fast-rtps.{node}"
        stated = {f"{at}.{in_cpp(k)}": t for k, t in words.items()}
        assert [violation(stated_data(), k, t) for k, t in stated.items()] == [
            None
        ] * len(words)
        both = [Profile(), Profile()]
        both[place] = expected
        assert list(profiles(stated)) == both


@pytest.mark.parametrize(
    "stated",
    [
        {"reliability.kind": "SYSTEM_DEFAULT_RELIABILITY_QOS"},
        {"durability.kind": "SYSTEM_DEFAULT_QOS"},
        {"liveliness.kind": ""},
        {"history.depth": "0"},
        {"deadline.period.sec": "0", "deadline.period.nanosec": "0"},
        {"deadline.period.sec": "2147483647", "deadline.period.nanosec": "4294967295"},
        {"avoid_ros_namespace_conventions": "YES"},
    ],
)
def test_what_leaves_a_policy_as_it_is(stated: dict[str, str]) -> None:
    properties = {f"dataport.ros2.reader_qos.{k}": t for k, t in stated.items()}
    assert all(violation(stated_data(), k, t) is None for k, t in properties.items())
    assert profiles(properties) == (Profile(), Profile())
    assert not list(problems(properties))


def test_an_endless_time_replaces_that_of_a_profile() -> None:
    properties = {
        "dataport.ros2.qos": "rosout",
        "dataport.ros2.writer_qos.lifespan.duration.sec": "2147483647",
    }
    writer, reader = profiles(properties)
    assert writer.lifespan is None
    assert reader.lifespan == PROFILES["rosout"].lifespan


CONTRADICTIONS = {
    ("ros2.reliability", "reliable", "ros2.writer_qos.reliability.kind"): (
        "BEST_EFFORT_RELIABILITY_QOS"
    ),
    ("ros2.depth", "5", "qos.depth"): "6",
    ("ros2.reader_qos.history.depth", "5", "fast-rtps.reader_qos.history.depth"): "6",
    ("ros2.deadline", "1", "fast-rtps.publisher.qos.deadline.period.seconds"): "2",
    ("ros2.history", "keep_all", "ros2.depth"): "5",
    (
        *("ros2.writer_qos.reliability.kind", "BEST_EFFORT_RELIABILITY_QOS"),
        "ros2.reader_qos.reliability.kind",
    ): "RELIABLE_RELIABILITY_QOS",
    ("ros2.qos", "map", "ros2.writer_qos.durability.kind"): "VOLATILE_DURABILITY_QOS",
}


@pytest.mark.parametrize("first", CONTRADICTIONS)
def test_contradictions_are_said_once(first: tuple[str, str, str]) -> None:
    key, text, other = first
    properties = {
        "dataport.marshaling_type": "ros2:std_msgs/Float32",
        f"dataport.{key}": text,
        f"dataport.{other}": CONTRADICTIONS[first],
    }
    [(place, message, hint)] = problems(properties)
    assert place in properties
    assert message
    assert hint


def test_qos_between_processes_is_that_of_a_connector_that_is_a_topic() -> None:
    between = {"dataport.qos.history": "keep_all", "dataport.qos.depth": "5"}
    assert not list(problems(between))
    assert profiles(between) == (Profile(), Profile())
    topic = {**between, "dataport.marshaling_type": "ros2:std_msgs/Float32"}
    assert len(list(problems(topic))) == 1
    del topic["dataport.qos.history"]
    assert profiles(topic) == (Profile(5), Profile(5))


def test_the_topic_by_any_transport() -> None:
    assert topic_of({}) is None
    for transport in TRANSPORTS:
        assert topic_of({f"dataport.{transport}.topic": " /x "}) == "/x"
