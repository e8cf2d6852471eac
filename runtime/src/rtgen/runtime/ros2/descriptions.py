"""The service `~/get_type_description` of nodes: the types that they use (REP 2016).

The answers are those of rcl.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple, TypeAlias

from rtgen.runtime.distribution.workers import Workers
from rtgen.runtime.failures import log
from rtgen.runtime.ros2.life_cycle import Members
from rtgen.runtime.ros2.network import Ros2Error, RosNetwork, RosService, RosTopic
from rtgen.runtime.ros2.services import Server
from rtgen.runtime.ros2.types import made

SERVICE: Final = "type_description_interfaces/srv/GetTypeDescription"
_HASH: Final = re.compile(r"RIHS01_[0-9a-f]{64}")


class Definition(NamedTuple):
    """The file of a type: `msg`, `srv`, `implicit` and so on, its text, and defaults of fields."""

    encoding: str
    text: str
    defaults: Mapping[str, str]


Source: TypeAlias = Callable[[str], Definition | None]
"""Function that returns the definition of a type (`std_msgs/msg/Bool`); None if it is unknown."""


class TypeDescriptions:
    """Serves the types that nodes use, until `close`; the network stays open."""

    def __init__(
        self,
        network: RosNetwork,
        nodes: Mapping[str, str],
        classes: Mapping[str, type[Any]],
        event_info: type[Any],
        source: Source,
    ) -> None:
        """Initialize with the fully qualified names of nodes by the `node` of their ends.

        `classes` are those of `SERVICE`. Raises Ros2Error.
        """
        self._network = network
        self._source = source
        self._workers = Workers()
        request, response = (classes[f"{SERVICE}_{k}"] for k in ("Request", "Response"))
        for node, name in nodes.items():
            service = RosService(
                request, response, f"{name}/get_type_description", event_info, node
            )
            server = Server(
                service, self._answering(node, response), self._workers, service.name
            )
            try:
                network.serve(service, server.take)
            except Ros2Error as error:
                log.warning("%s is not served: %s", service.name, error)

    def close(self) -> None:
        """Stop responding."""
        self._workers.close()

    def _answering(self, node: str, response: type[Any]) -> Callable[[Any], Any]:
        def answer(request: Any) -> Any:
            members = described(self._network.used.get(node, {}), request, self._source)
            return made(response._descriptor_, members)

        return answer


def described(
    used: Mapping[str, RosTopic | RosService], request: Any, source: Source
) -> Members:
    """Return the answer to a request, by the ends of the types that a node uses."""
    if not _HASH.fullmatch(request.type_hash):
        return _failure("Failed to parse type hash")
    # As in rcl, the hash counts, and not the name.
    with_hash = (each for each in used.values() if each.type_hash == request.type_hash)
    end = next(with_hash, None)
    if end is None:
        return _failure("Type not currently in use by this node")
    whole, others = end.described
    ordered = [whole, *(others[name] for name in sorted(others))]
    definitions = [source(each["type_name"]) for each in ordered]
    types = [*map(_with_defaults, ordered, definitions)]
    answer: Members = {
        "successful": True,
        "type_description": {
            "type_description": types[0],
            "referenced_type_descriptions": types[1:],
        },
    }
    if request.include_type_sources:
        answer["type_sources"] = [
            {
                "type_name": each["type_name"],
                "encoding": definition.encoding,
                "raw_file_contents": definition.text,
            }
            for each, definition in zip(ordered, definitions, strict=True)
            if definition is not None
        ]
    return answer


def _failure(reason: str) -> Members:
    return {"successful": False, "failure_reason": reason}


def _with_defaults(
    description: dict[str, Any], definition: Definition | None
) -> dict[str, Any]:
    defaults = {} if definition is None else definition.defaults
    fields = [
        {**field, "default_value": defaults.get(field["name"], "")}
        for field in description["fields"]
    ]
    return {**description, "fields": fields}
