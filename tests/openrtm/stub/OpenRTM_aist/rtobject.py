"""The component: callbacks, ports, configuration, contexts, also over CORBA."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any

import OpenRTM__POA
import RTC

from . import orb
from .configuration import ConfigAdmin, ConfigurationServant, Trans
from .contexts import CONTEXTS, FOREIGN, ExecutionContextBase
from .data_ports import InPort, OutPort
from .NVUtil import list_of
from .ports import PortBase
from .properties import Properties
from .values import split


class RTObject_impl(OpenRTM__POA.DataFlowComponent):
    """Base of components; users define the callbacks `on...`."""

    def __init__(self, manager: Any) -> None:
        self._manager = manager
        self._rtcout = manager.getLogbuf("rtobject")
        self._properties = Properties()
        self._configsets = ConfigAdmin(self._properties.getNode("conf"))
        self._configuration: Any = None
        self._ports: list[PortBase] = []
        self._own: list[ExecutionContextBase] = []
        self._foreign: list[Any] = []
        self._created = True
        self._raised = False
        self._objref = self._this()

    # Defined by a component's author.

    def onInitialize(self) -> Any:
        return RTC.RTC_OK

    def onFinalize(self) -> Any:
        return RTC.RTC_OK

    def onStartup(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onShutdown(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onActivated(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onDeactivated(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onExecute(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onStateUpdate(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onRateChanged(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onAborting(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onError(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    def onReset(self, ec_id: int) -> Any:
        return RTC.RTC_OK

    # Called by an author.

    def getInstanceName(self) -> str:
        return self._properties.getProperty("instance_name")

    def getTypeName(self) -> str:
        return self._properties.getProperty("type_name")

    def getCategory(self) -> str:
        return self._properties.getProperty("category")

    def getProperties(self) -> Properties:
        return self._properties

    def setProperties(self, properties: Properties) -> None:
        self._properties.mergeProperties(properties)

    def getObjRef(self) -> Any:
        return self._objref

    def bindParameter(
        self, param_name: str, var: list[Any], def_val: str, trans: Trans | None = None
    ) -> bool:
        """Bind a parameter; True in any case, also if it could not be bound."""
        self._configsets.bindParameter(param_name, var, def_val, trans)
        return True

    def addInPort(self, name: str, inport: InPort) -> bool:
        self._give_defaults(inport, f"port.inport.{name}")
        return self.addPort(inport)

    def addOutPort(self, name: str, outport: OutPort) -> bool:
        self._give_defaults(outport, f"port.outport.{name}")
        return self.addPort(outport)

    def _give_defaults(self, port: InPort | OutPort, key: str) -> None:
        defaults = self._properties.findNode(key)
        if defaults is not None:
            port.init(defaults)

    def addPort(self, port: PortBase) -> bool:
        """Add a port; False if there is a port of this name."""
        port.setOwner(self._objref, self.getInstanceName())
        if any(port.getName() == known.getName() for known in self._ports):
            return False
        self._ports.append(port)
        return True

    def removePort(self, port: PortBase) -> bool:
        if port not in self._ports:
            return False
        self._ports.remove(port)
        port.exit()
        return True

    def getExecutionContext(self, ec_id: int) -> Any:
        return self.get_context(ec_id)

    def getExecutionRate(self, ec_id: int) -> float:
        rate: float = self.get_context(ec_id).get_rate()
        return rate

    # ComponentAction and DataFlowComponentAction.

    def on_initialize(self) -> Any:
        code = self._call(self.onInitialize)
        active = self._properties.getProperty("configuration.active_config", "default")
        if self._configsets.activateConfigurationSet(active):
            self._configsets.update()
        return code

    def on_finalize(self) -> Any:
        return self._call(self.onFinalize)

    def on_startup(self, ec_id: int) -> Any:
        return self._call(self.onStartup, ec_id)

    def on_shutdown(self, ec_id: int) -> Any:
        return self._call(self.onShutdown, ec_id)

    def on_activated(self, ec_id: int) -> Any:
        self._configsets.update()
        code = self._call(self.onActivated, ec_id)
        if not self._raised:
            for port in self._ports:
                port.activateInterfaces()
        return code

    def on_deactivated(self, ec_id: int) -> Any:
        for port in self._ports:
            port.deactivateInterfaces()
        return self._call(self.onDeactivated, ec_id)

    def on_aborting(self, ec_id: int) -> Any:
        return self._call(self.onAborting, ec_id)

    def on_error(self, ec_id: int) -> Any:
        code = self._call(self.onError, ec_id)
        self._configsets.update()
        return code

    def on_reset(self, ec_id: int) -> Any:
        return self._call(self.onReset, ec_id)

    def on_execute(self, ec_id: int) -> Any:
        return self._call(self.onExecute, ec_id)

    def on_state_update(self, ec_id: int) -> Any:
        code = self._call(self.onStateUpdate, ec_id)
        self._configsets.update()
        return code

    def on_rate_changed(self, ec_id: int) -> Any:
        return self._call(self.onRateChanged, ec_id)

    def _call(self, callback: Callable[..., Any], *arguments: Any) -> Any:
        """Call a callback; a result other than a return code, or an exception, is an error."""
        self._raised = False
        try:
            code = callback(*arguments)
        except Exception:
            self._raised = True
            self._rtcout.RTC_ERROR(traceback.format_exc())
            return RTC.RTC_ERROR
        return code if code in RTC.ReturnCode_t._items else RTC.RTC_ERROR

    # LightweightRTObject.

    def initialize(self) -> Any:
        """Initialize, create the own contexts and start them."""
        if not self._created:
            return RTC.PRECONDITION_NOT_MET
        for kind, properties in self._context_plans():
            context = CONTEXTS[kind](properties)
            context.bindComponent(self, self._objref, len(self._own))
            self._own.append(context)
        code = self.on_initialize()
        if code != RTC.RTC_OK:
            return code
        self._created = False
        for context in self._own:
            context.start()
        return RTC.RTC_OK

    def _context_plans(self) -> list[tuple[str, Properties]]:
        """Return kind and settings of the own contexts."""
        common = self._properties.getNode("exec_cxt")
        named = self._properties.getProperty("execution_contexts")
        if not named:
            kind = common.getProperty("periodic.type", "PeriodicExecutionContext")
            return [(kind, common)]
        if named.strip().lower() == "none":
            # There is always one: by default with OpenRTM's settings.
            return [("PeriodicExecutionContext", Properties())]
        return [(each.partition("(")[0].strip(), common) for each in split(named)]

    def finalize(self) -> Any:
        """Call the last callbacks and release everything."""
        code = self.on_finalize()
        for context in self._own:
            context.close()
        for port in list(self._ports):
            port.exit()
        poa = orb.poa()
        for servant in (self._configuration, self):
            if servant is not None:
                poa.deactivate_object(poa.servant_to_id(servant))
        return code

    def is_alive(self, exec_context: Any) -> bool:
        return not self._created and self.get_context_handle(exec_context) >= 0

    def exit(self) -> Any:
        """Leave the contexts and the manager."""
        if self._created:
            return RTC.PRECONDITION_NOT_MET
        self._created = True
        for context in self._own:
            context.exit()
        for context in [each for each in self._foreign if each is not None]:
            context.remove_component(self._objref)
        self.finalize()
        self._manager.notifyFinalized(self)
        return RTC.RTC_OK

    def attach_context(self, exec_context: Any) -> int:
        self._foreign.append(exec_context)
        return FOREIGN + len(self._foreign) - 1

    def detach_context(self, exec_handle: int) -> Any:
        place = exec_handle - FOREIGN
        if not 0 <= place < len(self._foreign) or self._foreign[place] is None:
            return RTC.BAD_PARAMETER
        self._foreign[place] = None
        return RTC.RTC_OK

    def get_context(self, exec_handle: int) -> Any:
        if exec_handle >= FOREIGN:
            contexts, place = self._foreign, exec_handle - FOREIGN
        else:
            contexts, place = self.get_owned_contexts(), exec_handle
        return contexts[place] if 0 <= place < len(contexts) else None

    def get_owned_contexts(self) -> list[Any]:
        return [context.getObjRef() for context in self._own]

    def get_participating_contexts(self) -> list[Any]:
        return [context for context in self._foreign if context is not None]

    def get_context_handle(self, exec_context: Any) -> int:
        for first, contexts in (
            (0, self.get_owned_contexts()),
            (FOREIGN, self._foreign),
        ):
            for place, known in enumerate(contexts):
                if known is not None and known._is_equivalent(exec_context):
                    return first + place
        return -1

    # RTObject and SDO.

    def get_component_profile(self) -> Any:
        text = self._properties.getProperty
        return RTC.ComponentProfile(
            text("instance_name"),
            text("type_name"),
            text("description"),
            text("version"),
            text("vendor"),
            text("category"),
            [port.get_port_profile() for port in self._ports],
            None,
            list_of(self._properties),
        )

    def get_ports(self) -> list[Any]:
        return [port.getPortRef() for port in self._ports]

    def get_sdo_id(self) -> str:
        return self.getInstanceName()

    def get_sdo_type(self) -> str:
        return self._properties.getProperty("description")

    def get_configuration(self) -> Any:
        if self._configuration is None:
            self._configuration = ConfigurationServant(self._configsets)
        return self._configuration._this()


class DataFlowComponentBase(RTObject_impl):
    """The base class of components."""
