"""Messages of rmw_dds_common by which nodes on DDS know each other (`ros_discovery_info`)."""

from __future__ import annotations

from typing import ClassVar

from rtgen.runtime import idl
from rtgen.runtime.cdr import Aggregated, field


class Gid(Aggregated):
    """Identifier of a middleware entity."""

    _descriptor_: ClassVar = idl.struct(
        "rmw_dds_common::msg::Gid", data=idl.array(idl.UINT8, 16)
    )

    data: bytes = bytes(16)


class NodeEntitiesInfo(Aggregated):
    """A node with its readers and writers."""

    _descriptor_: ClassVar = idl.struct(
        "rmw_dds_common::msg::NodeEntitiesInfo",
        node_namespace=idl.string(256),
        node_name=idl.string(256),
        reader_gid_seq=idl.sequence(Gid),
        writer_gid_seq=idl.sequence(Gid),
    )

    node_namespace: str = ""
    node_name: str = ""
    reader_gid_seq: list[Gid] = field(default_factory=list)
    writer_gid_seq: list[Gid] = field(default_factory=list)


class ParticipantEntitiesInfo(Aggregated):
    """The nodes of a participant."""

    _descriptor_: ClassVar = idl.struct(
        "rmw_dds_common::msg::ParticipantEntitiesInfo",
        gid=Gid,
        node_entities_info_seq=idl.sequence(NodeEntitiesInfo),
    )

    gid: Gid = field(default_factory=Gid)
    node_entities_info_seq: list[NodeEntitiesInfo] = field(default_factory=list)
