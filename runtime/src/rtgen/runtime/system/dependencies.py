"""Service dependencies between components: order of activation and of finalization."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from rtgen.runtime.rtc.participant import Participant
from rtgen.runtime.services.connectors import ServiceConnector


class Dependencies(msgspec.Struct, eq=False):
    """Derives dependencies from service connections; both mappings may change later.

    `_connectors` has the connections of each instance by name.
    """

    _participants: Mapping[str, Participant]
    _connectors: Mapping[str, Mapping[str, Any]]

    def order(self, instances: Sequence[str]) -> list[str]:
        """Return the instances, each after the providers of its consumers.

        Instances in a cycle, or without dependencies, keep their order.
        """
        ordered: list[str] = []
        begun: set[str] = set()
        wanted = set(instances)

        def add(instance: str) -> None:
            if instance in begun:
                return
            begun.add(instance)
            for provider in self._providers(instance):
                if provider in wanted:
                    add(provider)
            ordered.append(instance)

        for instance in instances:
            add(instance)
        return ordered

    def awaited(self, instance: str) -> str:
        """Return a provider that is being activated and does not wait for this instance itself."""
        return next(
            (
                provider
                for provider in self._providers(instance)
                if self._is_activating(provider)
                and instance not in self._awaited_by(provider)
            ),
            "",
        )

    def _providers(self, instance: str) -> list[str]:
        """Return the instances of this system that provide services to a component."""
        providers = []
        for connector in tuple(self._connectors.get(instance, {}).values()):
            if isinstance(connector, ServiceConnector):
                for consumer, provider in connector.pairs:
                    if consumer.owner == instance and provider.owner != instance:
                        providers.append(provider.owner)
        return providers

    def _awaited_by(self, instance: str) -> set[str]:
        """Return the providers that an instance waits for, directly or indirectly."""
        instances: set[str] = set()
        waiting = [instance]
        while waiting:
            for provider in self._providers(waiting.pop()):
                if provider not in instances and self._is_activating(provider):
                    instances.add(provider)
                    waiting.append(provider)
        return instances

    def _is_activating(self, instance: str) -> bool:
        participant = self._participants.get(instance)
        return (
            participant is not None
            and participant.activating
            and participant.context.is_running()
        )
