"""`[ros2]` of rtgen.toml: the node that a system becomes, and the ports that are topics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import msgspec

from rtgen.compiler.diagnostics import Span
from rtgen.facts.adapter_constants import AdapterConstant, constants
from rtgen.facts.ros_marshaling import parse
from rtgen.facts.ros_qos import Profile
from rtgen.facts.ros_qos_words import POLICIES, profile_of, value_of
from rtgen.facts.ros_transforms import STATIC

if TYPE_CHECKING:
    from rtgen.compiler.project.file import Settings


class TopicEntry(msgspec.Struct, frozen=True, kw_only=True):
    """A port (`INSTANCE.PORT`) with its topic; `span` is None if a connection specifies the topic.

    `message` is that of `marshaling_type` (`std_msgs/msg/Float32`); None for the port's own type.
    `has_lifespan`: a lifespan is stated, which only an OutPort has.
    `constants` are members of what is converted, by paths, with their places.
    """

    instance: str
    port: str
    topic: str
    profile: Profile
    span: Span | None
    message: str | None = None
    has_lifespan: bool = False
    constants: tuple[tuple[str, AdapterConstant, Span | None], ...] = ()


class ServiceEntry(msgspec.Struct, frozen=True):
    """An operation (`INSTANCE.PORT.OPERATION`) with its service."""

    instance: str
    port: str
    operation: str
    service: str
    span: Span


class ActionEntry(msgspec.Struct, frozen=True):
    """A service port (`INSTANCE.PORT`) with its action."""

    instance: str
    port: str
    action: str
    span: Span


class TransformEntry(msgspec.Struct, frozen=True, kw_only=True):
    """An OutPort (`INSTANCE.PORT`) whose poses are a transform; a frame may be the message's."""

    instance: str
    port: str
    parent: str
    child: str
    span: Span


class Ros2Settings(msgspec.Struct, frozen=True, kw_only=True):
    """`[ros2]`. None: name of the system, ROS_DOMAIN_ID, loopback, rmw_zenoh's configuration.

    `zenoh` is the path of a Zenoh configuration, relative to the project; `interfaces`: write ROS 2
    interface files; `managed_nodes`: each component is a node with the services of life cycle and
    parameters; `boards`: functions of TECS boards are services, objects of CANopen nodes topics and
    parameters. `maintainer` (`NAME <EMAIL>`) and `license` are those of packages for colcon.
    """

    node: str | None = None
    namespace: str = "/"
    domain: int | None = None
    interface: str | None = None
    zenoh: str | None = None
    interfaces: bool = False
    managed_nodes: bool = True
    boards: bool = False
    maintainer: str | None = None
    license: str | None = None
    topics: tuple[TopicEntry, ...] = ()
    services: tuple[ServiceEntry, ...] = ()
    actions: tuple[ActionEntry, ...] = ()
    transforms: tuple[TransformEntry, ...] = ()
    static_transforms: tuple[Mapping[str, Any], ...] = ()

    @property
    def is_used(self) -> bool:
        """Whether the project has settings for ROS 2, whose nodes may join its systems."""
        return self != Ros2Settings()


def ros2_settings(settings: Settings) -> Ros2Settings:
    """Return the section of a validated rtgen.toml."""
    if "ros2" not in settings.content:
        return Ros2Settings()
    section = settings.content["ros2"]
    rest = {
        key: value
        for key, value in section.items()
        if key not in ("topics", "services", "actions", "tf")
    }
    if "namespace" in rest:
        rest["namespace"] = "/" + rest["namespace"].strip("/")
    topics = []
    for key, value in section.get("topics", {}).items():
        table: dict[str, Any]
        instance, _, port = key.partition(".")
        table = {"topic": value} if isinstance(value, str) else value
        stated = {
            word: value_of(word, table[word])
            for word in ("qos", *POLICIES)
            if word in table
        }
        fixed = constants(table.get("set", {}))
        topics.append(
            TopicEntry(
                instance=instance,
                port=port,
                topic=table["topic"],
                profile=profile_of(stated),
                has_lifespan="lifespan" in stated,
                span=settings.span("ros2.topics", key),
                message=parse(table.get("marshaling_type", "")),
                constants=tuple(
                    (path, each, settings.span("ros2.topics", key, path))
                    for path, each in fixed.items()
                ),
            )
        )
    transforms = section.get("tf", {})
    return Ros2Settings(
        **{"boards": True, **rest},
        transforms=tuple(
            TransformEntry(
                instance=key.partition(".")[0],
                port=key.partition(".")[2],
                parent=table.get("parent", ""),
                child=table.get("child", ""),
                span=settings.span("ros2.tf", key),
            )
            for key, table in transforms.items()
            if key != STATIC
        ),
        static_transforms=_list(transforms.get(STATIC, ())),
        topics=tuple(topics),
        services=tuple(
            ServiceEntry(instance, port, of, name, settings.span("ros2.services", key))
            for key, name in section.get("services", {}).items()
            for instance, port, of in [key.split(".")]
        ),
        actions=tuple(
            ActionEntry(instance, port, name, settings.span("ros2.actions", key))
            for key, name in section.get("actions", {}).items()
            for instance, port in [key.split(".")]
        ),
    )


def _list(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, list | tuple) else (value,)
