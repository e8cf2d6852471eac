"""A component as `OpenRTM::DataFlowComponent`, and its execution contexts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, TypeVar

from omniORB import any as anys

from rtgen.facts.openrtm_ports import RUNTIME
from rtgen.runtime.corba.rt_objects.configuration import Configuration
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.ports import PortService
from rtgen.runtime.corba.rt_objects.wire import (
    CONFIGURATION,
    DATA_FLOW_COMPONENT,
    EXECUTION_CONTEXT,
    ComponentProfile,
    DeviceProfile,
    ExecutionContextProfile,
    InterfaceNotImplemented,
    InvalidParameter,
    NameValue,
    ServiceProfile,
    values,
)
from rtgen.runtime.return_codes import (
    BAD_PARAMETER,
    CREATED_STATE,
    PRECONDITION_NOT_MET,
    UNSUPPORTED,
    LifeCycleState,
    ReturnCode_t,
)
from rtgen.runtime.rtc.component import Component
from rtgen.runtime.rtc.execution_context import ExecutionContext

_T = TypeVar("_T")
_NO_HANDLE = -1
_OF_CONTEXTS = "is_running start stop get_rate set_rate get_kind"
"""Operations of `RTC::ExecutionContext` that the context itself carries out."""
_CALLBACKS = """
    on_initialize on_finalize on_startup on_shutdown on_activated on_deactivated on_aborting
    on_error on_reset on_execute on_state_update on_rate_changed
    """


class ContextService:
    """`RTC::ExecutionContextService` of a context; its participants are of this process.

    There is one object of a context, of the component that owns it.
    """

    def __init__(
        self, context: ExecutionContext, exported: Exported, owner: RtObject
    ) -> None:
        self.context = context
        self._exported = exported
        self._owner = owner
        self.reference = exported.serve(EXECUTION_CONTEXT, self)

    def add_component(self, reference: Any) -> ReturnCode_t:
        """Return UNSUPPORTED for a component of another process."""
        return self._asked(reference, self.context.add_component, UNSUPPORTED)

    def remove_component(self, reference: Any) -> ReturnCode_t:
        """Return BAD_PARAMETER for a component of another process, as those below."""
        return self._asked(reference, self.context.remove_component, BAD_PARAMETER)

    def activate_component(self, reference: Any) -> ReturnCode_t:
        """Request ACTIVE; executed at the next tick."""
        return self._asked(reference, self.context.activate_component, BAD_PARAMETER)

    def deactivate_component(self, reference: Any) -> ReturnCode_t:
        """Request INACTIVE."""
        return self._asked(reference, self.context.deactivate_component, BAD_PARAMETER)

    def reset_component(self, reference: Any) -> ReturnCode_t:
        """Request INACTIVE after an ERROR."""
        return self._asked(reference, self.context.reset_component, BAD_PARAMETER)

    def get_component_state(self, reference: Any) -> LifeCycleState:
        """Return the state of a component; CREATED if it does not participate."""
        return self._asked(reference, self.context.get_component_state, CREATED_STATE)

    def get_profile(self) -> ExecutionContextProfile:
        """See `RTC::ExecutionContextService`."""
        return ExecutionContextProfile(
            self.context.get_kind(),
            self.context.get_rate(),
            self._owner.reference,
            self._owner.references_of(
                participant.component
                for participant in self.context.participants
                if participant.component is not self.context.owner
            ),
            [],
        )

    def _asked(self, reference: Any, ask: Callable[[Component], _T], unknown: _T) -> _T:
        """Return what the context says of a component; `unknown` for one of another process."""
        found = self._exported.local(reference)
        return ask(found.component) if isinstance(found, RtObject) else unknown


class RtObject:
    """`OpenRTM::DataFlowComponent`: a component of this process with its ports.

    Only the middleware may call callbacks, and a component ends with the run: both are UNSUPPORTED
    for clients.
    """

    def __init__(
        self,
        component: Component,
        ports: Sequence[PortService],
        exported: Exported,
        published: Mapping[str, RtObject],
    ) -> None:
        self.component = component
        self.ports = ports
        self._exported = exported
        self._published = published
        self.reference = exported.serve(DATA_FLOW_COMPONENT, self)
        self._configuration = exported.serve(CONFIGURATION, Configuration(component))
        self._contexts: dict[int, ContextService] = {}
        for port in ports:
            port.owner = self.reference

    def close(self) -> None:
        """Close the connections to other processes, and deactivate the objects."""
        for port in self.ports:
            port.close()
        for context in self._contexts.values():
            self._exported.withdraw(context.reference)
        self._exported.withdraw(self._configuration)
        self._exported.withdraw(self.reference)

    # RTObject

    def get_component_profile(self) -> ComponentProfile:
        """See `RTC::RTObject`."""
        profile = self.component.profile
        texts = {
            "instance_name": self.component.instance_name,
            "type_name": profile.type_name,
            "implementation_id": profile.type_name,
            "description": profile.description,
            "version": profile.version,
            "vendor": profile.vendor,
            "category": profile.category,
            "activity_type": profile.activity_type or profile.activity,
            "max_instance": str(profile.max_instances),
            "language": "Python",
            "lang_type": "SCRIPT",
            RUNTIME: "embedded",
            "naming.names": f"{self.component.instance_name}.rtc",
        }
        return ComponentProfile(
            self.component.instance_name,
            profile.type_name,
            profile.description,
            profile.version,
            profile.vendor,
            profile.category,
            [port.get_port_profile() for port in self.ports],
            None,
            values(texts),
        )

    def get_ports(self) -> list[Any]:
        """Return references to the port services."""
        return [port.reference for port in self.ports]

    # LightweightRTObject

    def is_alive(self, reference: Any) -> bool:
        """Return whether it is initialized; with a context, whether it participates in it."""
        found = self._exported.local(reference)
        context = found.context if isinstance(found, ContextService) else None
        if context is None and reference is not None:
            return False
        return self.component.is_alive(context)

    def get_owned_contexts(self) -> list[Any]:
        """Return the contexts that the component owns."""
        return self._references(self.component.get_owned_contexts())

    def get_participating_contexts(self) -> list[Any]:
        """Return the contexts of others in which it participates."""
        return self._references(self.component.get_participating_contexts())

    def get_context(self, handle: int) -> Any:
        """Return the context of a handle; nil for an unknown one."""
        context = self.component.get_context(handle)
        return next(iter(self._references([context])), None)

    def get_context_handle(self, reference: Any) -> int:
        """Return the handle of a context, -1 for an unknown one."""
        found = self._exported.local(reference)
        if not isinstance(found, ContextService):
            return _NO_HANDLE
        return self.component.get_context_handle(found.context)

    def _references(self, contexts: Sequence[Any]) -> list[Any]:
        found = []
        for context in contexts:
            if isinstance(context, ExecutionContext) and context.owner is not None:
                owner = self._published.get(context.owner.instance_name)
                if owner is not None:
                    found.append(owner._service(context).reference)
        return found

    def _service(self, context: ExecutionContext) -> ContextService:
        """Return the object of an own context."""
        if id(context) not in self._contexts:
            made = ContextService(context, self._exported, self)
            self._contexts[id(context)] = made
        return self._contexts[id(context)]

    def references_of(self, components: Iterable[Component]) -> list[Any]:
        """Return the references of components of this process."""
        found = [self._published.get(each.instance_name) for each in components]
        return [each.reference for each in found if each is not None]

    # SDO

    def get_sdo_id(self) -> str:
        """Return the instance name."""
        return self.component.instance_name

    def get_sdo_type(self) -> str:
        """Return the description of the component."""
        return self.component.profile.description

    def get_service_profile(self, identity: str) -> ServiceProfile:
        """Raise InvalidParameter."""
        raise InvalidParameter(f"there is no service {identity}")

    def get_sdo_service(self, identity: str) -> Any:
        """Raise InvalidParameter."""
        raise InvalidParameter(f"there is no service {identity}")

    def get_configuration(self) -> Any:
        """Return the reference of the configuration."""
        return self._configuration

    def get_monitoring(self) -> Any:
        """Raise InterfaceNotImplemented."""
        raise InterfaceNotImplemented("there is no monitoring")

    def get_status_list(self) -> list[NameValue]:
        """Return the reason of the last failure."""
        return values({"reason": self.component.reason})

    def get_status(self, name: str) -> Any:
        """Return the value of a status. Raises InvalidParameter."""
        if name != "reason":
            raise InvalidParameter(f"there is no status {name}")
        return anys.to_any(self.component.reason)


_ANSWERS: Final[dict[str, object]] = {
    # It is initialized, and participates in its own context.
    **dict.fromkeys(("initialize", "finalize"), PRECONDITION_NOT_MET),
    **dict.fromkeys(("exit", *_CALLBACKS.split()), UNSUPPORTED),
    # `add_component` and `remove_component` of a context do that.
    "attach_context": _NO_HANDLE,
    "detach_context": UNSUPPORTED,
    "get_owned_organizations": [],
    "get_organizations": [],
    "get_device_profile": DeviceProfile(),
    "get_service_profiles": [],
}
"""Operations with the same answer for all components."""


def _answering(answer: object) -> Callable[..., object]:
    return lambda self, *arguments: answer


def _forwarding(name: str) -> Callable[..., object]:
    return lambda self, *arguments: getattr(self.context, name)(*arguments)


for _name in _OF_CONTEXTS.split():
    setattr(ContextService, _name, _forwarding(_name))
for _name, _answer in _ANSWERS.items():
    setattr(RtObject, _name, _answering(_answer))
