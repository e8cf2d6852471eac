"""Key expressions of a system: `SYSTEM/topic/...`, `service`, `presence`, `flow`.

`SYSTEM/topic/TOPIC/TYPE` has the samples of a topic, `SYSTEM/service/SERVICE` is a queryable,
`SYSTEM/presence/NAME/ID` a liveliness token, `SYSTEM/flow/TOPIC/TYPE/ID` the token and the
acknowledgements of a subscription that keeps all samples, and at `.../ID/sent` publishers report
what they have sent.
"""

from __future__ import annotations

import msgspec

from rtgen.runtime.distribution.medium import Topic, check_name, type_name


class Keys(msgspec.Struct, frozen=True, gc=False):
    """The key expressions of one system. Methods raise MediumError for a wrong name."""

    system: str

    @classmethod
    def of(cls, system: str) -> Keys:
        """Those of a system of this name."""
        return cls(check_name(system))

    def topic(self, topic: Topic) -> str:
        """The key of the samples of a topic."""
        return f"{self.system}/topic/{check_name(topic.name)}/{type_name(topic.type)}"

    def flow(self, topic: Topic, identity: str) -> str:
        """The key of a subscription that keeps all samples; `*` for all of them."""
        name = check_name(topic.name)
        return f"{self.system}/flow/{name}/{type_name(topic.type)}/{identity}"

    def service(self, service: str) -> str:
        """The key of a service."""
        return f"{self.system}/service/{check_name(service)}"

    def presence(self, name: str, identity: str) -> str:
        """The key of one presence of a name."""
        return f"{self.system}/presence/{check_name(name)}/{identity}"

    def presences(self, prefix: str) -> str:
        """The keys of all names that begin with a prefix, and perhaps of others."""
        parts = "".join(f"{part}/" for part in prefix.split("/")[:-1])
        return f"{self.system}/presence/{parts}**"

    def present(self, key: str) -> str:
        """The name of the key of a presence."""
        return key.removeprefix(f"{self.system}/presence/").rpartition("/")[0]
