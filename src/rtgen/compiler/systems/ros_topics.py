"""Judges the QoS of ports that are topics of ROS 2 (`[ros2.topics]` of rtgen.toml)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Protocol

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.model import PortKind
from rtgen.compiler.model.system_links import DATA_KINDS, Known
from rtgen.compiler.systems.rules import TOPIC_QOS
from rtgen.facts import ros_qos


class TopicEntry(Protocol):
    """A port with its topic, as `project.ros2.TopicEntry`."""

    @property
    def instance(self) -> str: ...
    @property
    def port(self) -> str: ...
    @property
    def topic(self) -> str: ...
    @property
    def profile(self) -> ros_qos.Profile: ...
    @property
    def has_lifespan(self) -> bool: ...
    @property
    def span(self) -> Span | None: ...


def findings(
    topics: Sequence[TopicEntry], ends: Mapping[str, Known]
) -> Iterator[Diagnostic]:
    """Yield the diagnostics about QoS that has no effect, or lets two ports exchange nothing.

    `ends` maps the instances of a system to their definitions; other ports are not judged.
    """
    writers = [entry for entry in topics if _kind(entry, ends) is PortKind.OUTPORT]
    readers = [entry for entry in topics if _kind(entry, ends) is PortKind.INPORT]
    for reader in readers:
        if reader.has_lifespan:
            message = f"the lifespan of {_name(reader)} has no effect: a subscription has none"
            hint = "set it at the publisher, or remove it"
            yield TOPIC_QOS.at(reader.span, message, hint=hint)
    by_topic: dict[str, list[TopicEntry]] = {}
    for writer in writers:
        by_topic.setdefault(writer.topic, []).append(writer)
    for reader in readers:
        for writer in by_topic.get(reader.topic, ()):
            unfit = ros_qos.misfits(writer.profile, reader.profile)
            if unfit:
                values = ros_qos.values_of(unfit)
                message = (
                    f"{_name(reader)} gets nothing of {_name(writer)}, which is the same topic: "
                    f"{values}"
                )
                hint = ros_qos.change(unfit, writes=False)
                yield TOPIC_QOS.at(reader.span, message, hint=hint)


def _kind(entry: TopicEntry, ends: Mapping[str, Known]) -> PortKind | None:
    known = ends.get(entry.instance)
    ports = () if known is None else known.component.ports
    kinds = (p.kind for p in ports if p.name == entry.port and p.kind in DATA_KINDS)
    return next(kinds, None)


def _name(entry: TopicEntry) -> str:
    return f"{entry.instance}.{entry.port}"
