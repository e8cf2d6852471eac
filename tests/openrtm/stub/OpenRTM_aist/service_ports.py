"""Service ports: providers, consumers, and their matching."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import RTC
from omniORB import CORBA

from . import orb
from .ports import PortBase


class CorbaConsumer:
    """A consumer's reference; empty until a connection sets it."""

    def __init__(self, interfaceType: Any = None) -> None:
        self._type = interfaceType
        self._reference: Any = None
        self._servant: Any = None

    def setObject(self, reference: Any) -> bool:
        if CORBA.is_nil(reference):
            return False
        narrowed = (
            reference._narrow(self._type) if self._type is not None else reference
        )
        if narrowed is None:
            return False
        self._reference = narrowed
        self._servant = orb.local(narrowed)
        return True

    def releaseObject(self) -> None:
        self._reference = self._servant = None

    def _ptr(self, get_ref: bool = False) -> Any:
        """Return the object; None if unconnected, the servant if it is local and was active."""
        if get_ref or self._servant is None:
            return self._reference
        return self._servant


@dataclass
class Provider:
    """A servant that is reachable while its component is active."""

    instance_name: str
    type_name: str
    servant: Any
    oid: Any
    ior: str
    active: bool = False


@dataclass
class Consumer:
    """A consumer and its reference, with the connection."""

    instance_name: str
    type_name: str
    consumer: CorbaConsumer
    connector_id: str = ""


class CorbaPort(PortBase):
    """Several interfaces of both polarities behind one port."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._providers: list[Provider] = []
        self._consumers: list[Consumer] = []
        self.addProperty("port.port_type", "CorbaPort")

    def registerProvider(
        self, instance_name: str, type_name: str, provider: Any
    ) -> bool:
        if any(known.instance_name == instance_name for known in self._providers):
            return False
        poa = orb.poa()
        oid = poa.activate_object(provider)
        ior = orb.to_text(poa.id_to_reference(oid))
        poa.deactivate_object(oid)
        self._providers.append(Provider(instance_name, type_name, provider, oid, ior))
        return True

    def registerConsumer(
        self, instance_name: str, type_name: str, consumer: CorbaConsumer
    ) -> bool:
        if any(known.instance_name == instance_name for known in self._consumers):
            return False
        self._consumers.append(Consumer(instance_name, type_name, consumer))
        return True

    def _interfaces(self) -> list[Any]:
        return [
            RTC.PortInterfaceProfile(each.instance_name, each.type_name, polarity)
            for polarity, known in (
                (RTC.PROVIDED, self._providers),
                (RTC.REQUIRED, self._consumers),
            )
            for each in known
        ]

    def activateInterfaces(self) -> None:
        for provider in self._providers:
            if not provider.active:
                orb.poa().activate_object_with_id(provider.oid, provider.servant)
                provider.active = True

    def deactivateInterfaces(self) -> None:
        for provider in self._providers:
            if provider.active:
                orb.poa().deactivate_object(provider.oid)
                provider.active = False

    def publishInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        for each in self._providers:
            given[self._key("provided", each)] = each.ior
            given[f"port.{each.type_name}.{each.instance_name}"] = each.ior
        return RTC.RTC_OK

    def subscribeInterfaces(self, profile: Any, given: dict[str, str]) -> Any:
        """Set each consumer by the profile's mapping, else by type and name.

        `strict` requires a reference only: one of another interface leaves the consumer empty.
        """
        strict = given.get("port.connection.strictness") == "strict"
        for each in self._consumers:
            mapped = given.get(self._key("required", each), "")
            ior = given.get(mapped, "") or given.get(
                f"port.{each.type_name}.{each.instance_name}", ""
            )
            if ior:
                each.connector_id = profile.connector_id
                each.consumer.setObject(orb.from_text(ior))
            elif strict:
                return RTC.RTC_ERROR
        return RTC.RTC_OK

    def unsubscribeInterfaces(self, profile: Any) -> None:
        for each in self._consumers:
            if each.connector_id == profile.connector_id:
                each.consumer.releaseObject()
                each.connector_id = ""

    def _key(self, polarity: str, each: Provider | Consumer) -> str:
        port = self._full_name.removeprefix(f"{self._instance}.")
        return (
            f"{self._instance}.port.{port}.{polarity}."
            f"{each.type_name}.{each.instance_name}"
        )
