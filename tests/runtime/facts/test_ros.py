"""Names, QoS, tokens and attachments of ROS 2 compared with recorded ones.

Recorded: the design document of rmw_zenoh, tests of rmw_dds_common, rmw_cyclonedds.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.facts import ros_names, ros_qos, ros_zenoh
from rtgen.facts.ros_qos import Durability, History, Liveliness, Profile, Reliability
from rtgen.facts.ros_zenoh import Attachment, Entity, Node

STRING = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"


@pytest.mark.parametrize(
    ("name", "namespace", "full", "topic"),
    [
        ("chatter", "/", "/chatter", "rt/chatter"),
        ("chatter", "/robot1", "/robot1/chatter", "rt/robot1/chatter"),
        ("/chatter", "/robot1", "/chatter", "rt/chatter"),
        ("ns/chatter", "", "/ns/chatter", "rt/ns/chatter"),
    ],
)
def test_topics(name: str, namespace: str, full: str, topic: str) -> None:
    assert ros_names.qualified(name, namespace) == full
    assert ros_names.dds_topic(full) == topic


@pytest.mark.parametrize(
    "name", ["", "/", "1a", "a b", "a//b", "a/", "a__b", "~x", "{node}", "ä", "a" * 249]
)
def test_no_names(name: str) -> None:
    assert ros_names.violation(name)
    with pytest.raises(ValueError, match=r"consists of|has no|is longer"):
        ros_names.qualified(name)


def test_services() -> None:
    topics = ros_names.dds_service_topics("/add_two_ints")
    assert topics == ("rq/add_two_intsRequest", "rr/add_two_intsReply")


@pytest.mark.parametrize(
    ("written", "name", "dds"),
    [
        ("std_msgs/Float32", "std_msgs/msg/Float32", "std_msgs::msg::dds_::Float32_"),
        ("std_msgs/msg/String", "std_msgs/msg/String", "std_msgs::msg::dds_::String_"),
        (
            "example_interfaces/srv/AddTwoInts_Request",
            "example_interfaces/srv/AddTwoInts_Request",
            "example_interfaces::srv::dds_::AddTwoInts_Request_",
        ),
        (
            "rmw_dds_common/msg/ParticipantEntitiesInfo",
            "rmw_dds_common/msg/ParticipantEntitiesInfo",
            "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
        ),
    ],
)
def test_types(written: str, name: str, dds: str) -> None:
    assert ros_names.parse_type(written) == name
    assert ros_names.dds_type(name) == dds


@pytest.mark.parametrize(
    "text", ["Float32", "std_msgs/float32", "a/b/c/D", "Std/msg/X", "a/x/B"]
)
def test_no_types(text: str) -> None:
    assert ros_names.parse_type(text) is None


def test_user_data() -> None:
    """The text is that of rmw_dds_common's test_qos."""
    hash_ = "RIHS01_000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f"
    data = ros_names.user_data(hash_)
    assert data == f"typehash={hash_};".encode()
    assert ros_names.parse_user_data(data) == {"typehash": hash_}
    both = ros_names.user_data(hash_, clientid="1.2")
    assert both == f"clientid=1.2;typehash={hash_};".encode()
    assert ros_names.parse_user_data(both)["clientid"] == "1.2"
    assert ros_names.PARTICIPANT_DATA == b"enclave=/;"


@pytest.mark.parametrize(
    ("data", "pairs"),
    [
        (b"", {}),
        (b"key=value;", {"key": "value"}),
        (b"typehash=;alone;a=b=c", {"typehash": "", "a": "b=c"}),
        (b"\xff;=;", {}),
    ],
)
def test_user_data_of_others(data: bytes, pairs: dict[str, str]) -> None:
    assert ros_names.parse_user_data(data) == pairs


def test_endpoint_id() -> None:
    """As written by `std::setw(2)` without a fill."""
    gid = bytes((1, 16, 0xAB, 0)) + bytes(12)
    assert ros_names.endpoint_id(gid) == " 1.10.ab.0" + ".0" * 12


PROFILES = {
    "default": "RELIABLE VOLATILE KEEP_LAST 10",
    "sensor_data": "BEST_EFFORT VOLATILE KEEP_LAST 5",
    "services_default": "RELIABLE VOLATILE KEEP_LAST 10",
    "parameters": "RELIABLE VOLATILE KEEP_LAST 1000",
    "parameter_events": "RELIABLE VOLATILE KEEP_LAST 1000",
    "clock": "BEST_EFFORT VOLATILE KEEP_LAST 1",
    "rosout": "RELIABLE TRANSIENT_LOCAL KEEP_LAST 1000",
    "static_tf": "RELIABLE TRANSIENT_LOCAL KEEP_LAST 1",
    "map": "RELIABLE TRANSIENT_LOCAL KEEP_LAST 1",
    "action_status": "RELIABLE TRANSIENT_LOCAL KEEP_LAST 1",
}


def test_profiles() -> None:
    found = {
        name: f"{p.reliability.name} {p.durability.name} {p.history.name} {p.depth}"
        for name, p in ros_qos.PROFILES.items()
    }
    assert found == PROFILES


@pytest.mark.parametrize(
    ("domain", "name", "type_", "hash_", "key"),
    [
        (
            *(0, "/chatter", "std_msgs/msg/String", STRING),
            f"0/chatter/std_msgs::msg::dds_::String_/{STRING}",
        ),
        (
            *(0, "/robot1/chatter", "std_msgs/msg/String", STRING),
            f"0/robot1/chatter/std_msgs::msg::dds_::String_/{STRING}",
        ),
        (
            *(2, "/add_two_ints", "example_interfaces/srv/AddTwoInts", ADD),
            f"2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD}",
        ),
    ],
)
def test_key_expressions(
    domain: int, name: str, type_: str, hash_: str, key: str
) -> None:
    assert ros_zenoh.key_expression(domain, name, type_, hash_) == key


LISTENER = Node(2, "aac3178e146ba6f1fc6e6a4085e77f21", 0, "listener")
TALKER = Node(2, "8b20917502ee955ac4476e0266340d5c", 0, "talker")
SERVER = Node(2, "f9980ee0495eaafb3e38f0d19e2eae12", 0, "add_two_ints_server")
CHATTER = "/chatter", "std_msgs/msg/String", STRING
SERVICE = "/add_two_ints", "example_interfaces/srv/AddTwoInts", ADD


@pytest.mark.parametrize(
    ("node", "entity", "token"),
    [
        (
            LISTENER,
            Entity("MS", *CHATTER, Profile(10)),
            "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MS/%/%/listener/%chatter/"
            f"std_msgs::msg::dds_::String_/{STRING}/::,10:,:,:,,",
        ),
        (
            TALKER,
            Entity("MP", *CHATTER, Profile(7)),
            "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/"
            f"std_msgs::msg::dds_::String_/{STRING}/::,7:,:,:,,",
        ),
        (
            SERVER,
            Entity("SS", *SERVICE, Profile(10)),
            "@ros2_lv/2/f9980ee0495eaafb3e38f0d19e2eae12/0/10/SS/%/%/add_two_ints_server/"
            f"%add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD}/::,10:,:,:,,",
        ),
    ],
)
def test_tokens(node: Node, entity: Entity, token: str) -> None:
    assert ros_zenoh.entity_token(node, 10, entity) == token


def test_token_of_a_node() -> None:
    expected = "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener"
    assert ros_zenoh.node_token(LISTENER) == expected
    in_space = Node(0, "a1", 3, "arm", "/left/hand", "/enclave")
    assert (
        ros_zenoh.node_token(in_space) == "@ros2_lv/0/a1/3/3/NN/%enclave/%left%hand/arm"
    )


QOS = {
    "::,10:,:,:,,": Profile(),
    "2::,5:,:,:,,": ros_qos.PROFILES["sensor_data"],
    ":1:,1:,:,:,,": ros_qos.PROFILES["map"],
    ":1:,1000:,:10,0:,,": ros_qos.PROFILES["rosout"],
    "::2,:,:,:,,": Profile(42, history=History.KEEP_ALL),
    "::,10:0,1000000:,:3,2,5": Profile(
        deadline=1_000_000, liveliness=Liveliness.MANUAL_BY_TOPIC, lease=2_000_000_005
    ),
}


@pytest.mark.parametrize("text", QOS)
def test_qos_of_tokens(text: str) -> None:
    assert ros_zenoh.qos_text(QOS[text]) == text
    assert ros_zenoh.parse_qos(text) == QOS[text]


DURATIONS = st.none() | st.integers(0, 10**12)


@given(
    st.builds(
        Profile,
        depth=st.integers(0, 10**6),
        reliability=st.sampled_from(Reliability),
        durability=st.sampled_from(Durability),
        history=st.sampled_from(History),
        deadline=DURATIONS,
        lifespan=DURATIONS,
        liveliness=st.sampled_from(Liveliness),
        lease=DURATIONS,
    )
)
def test_qos_is_read_as_written(profile: Profile) -> None:
    assert ros_zenoh.parse_qos(ros_zenoh.qos_text(profile)) == profile


@pytest.mark.parametrize(
    "text", ["", "::::", "x::,10:,:,:,,", "::,10:,:,:,", "9::,10:,:,:,,"]
)
def test_no_qos(text: str) -> None:
    with pytest.raises(ValueError, match=r".+"):
        ros_zenoh.parse_qos(text)


def test_attachment() -> None:
    value = Attachment(7, 1_234_567_890_123, bytes(range(16)))
    octets = ros_zenoh.attachment(value)
    expected = (
        "0700000000000000" "cb04fb711f010000" "10" "000102030405060708090a0b0c0d0e0f"
    )
    assert octets.hex() == expected
    assert ros_zenoh.parse_attachment(octets) == value
    with pytest.raises(ValueError, match="16 octets"):
        ros_zenoh.attachment(value._replace(gid=b"short"))


@pytest.mark.parametrize("octets", [b"", bytes(32), bytes(33), bytes(34)])
def test_no_attachment(octets: bytes) -> None:
    with pytest.raises(ValueError, match="not an attachment"):
        ros_zenoh.parse_attachment(octets)
