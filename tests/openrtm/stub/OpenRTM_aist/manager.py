"""The manager: factories, components, the ORB, and the process around them."""

from __future__ import annotations

import importlib.util
import re
import signal
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import RTC

from . import CORBA_RTCUtil, log, orb
from .manager_config import INHERITED, configuration, orb_arguments
from .naming import NamingManager, formatted
from .properties import Properties
from .values import split, toBool


def Delete(component: Any) -> None:
    """Function for a factory to delete a component."""


@dataclass
class Factory:
    """Creates components of a kind; slots in `numbers` belong to living ones."""

    profile: Properties
    new: Callable[[Any], Any]
    numbers: list[Any] = field(default_factory=list)

    def take(self, component: Any) -> int:
        """Return the lowest free number."""
        if None not in self.numbers:
            self.numbers.append(None)
        number = self.numbers.index(None)
        self.numbers[number] = component
        return number

    def release(self, component: Any) -> None:
        self.numbers = [None if each is component else each for each in self.numbers]


class Manager:
    """One for a process: `init`, `setModuleInitProc`, `activateManager`, `runManager`."""

    _manager: ClassVar[Manager | None] = None

    def __init__(self, config: Properties) -> None:
        self._config = config
        self._handler = log.begin(config)
        self._orb = orb.start(orb_arguments(config))
        self._naming = NamingManager(self._orb, config)
        self._factories: dict[str, Factory] = {}
        self._components: dict[str, Any] = {}
        self._init_procedure: Callable[[Manager], None] | None = None
        self._ended = threading.Event()
        self._runner: threading.Thread | None = None

    @classmethod
    def init(cls, argv: list[str]) -> Manager:
        if cls._manager is None:
            cls._manager = cls(configuration(argv))
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, lambda *_: cls.instance().terminate())
        return cls._manager

    @classmethod
    def instance(cls) -> Manager:
        return cls._manager or cls.init(sys.argv[:1])

    def getConfig(self) -> Properties:
        return self._config

    def getORB(self) -> Any:
        return self._orb

    def getPOA(self) -> Any:
        return orb.poa()

    def getNaming(self) -> NamingManager:
        return self._naming

    def getLogbuf(self, name: str = "manager") -> log.Logger:
        return log.Logger(name)

    def setModuleInitProc(self, procedure: Callable[[Manager], None]) -> None:
        self._init_procedure = procedure

    def activateManager(self) -> bool:
        """Accept calls, preload, call the init procedure, create, connect, activate."""
        orb.activate()
        setting = self._config.getProperty
        for name in split(setting("manager.modules.preload")):
            self.load(name, f"{Path(name).stem}Init")
        if self._init_procedure is not None:
            self._init_procedure(self)
        for text in split(setting("manager.components.precreate")):
            self.createComponent(text)
        for text in split(setting("manager.components.preconnect")):
            self._connect(text)
        for name in split(setting("manager.components.preactivation")):
            component = self.getComponent(name)
            if component is not None:
                CORBA_RTCUtil.activate(component.getObjRef())
        return True

    def runManager(self, no_block: bool | None = None) -> None:
        """Return when the manager has ended; at once with `no_block`."""
        if no_block:
            self._runner = threading.Thread(target=self._run, daemon=True)
            self._runner.start()
        else:
            self._run()

    def _run(self) -> None:
        # A wait without a time-out would block the handling of signals.
        while not self._ended.wait(0.2):
            pass
        # The call that ended the last component gets its answer before the ORB ends.
        time.sleep(0.1)
        self.shutdown()

    def terminate(self) -> None:
        """Make `runManager` end."""
        self._ended.set()

    def shutdown(self) -> None:
        """End all components, the ORB, and the manager."""
        if Manager._manager is not self:
            return
        self._ended.set()
        for component in self.getComponents():
            component.exit()
        self._naming.close()
        self.shutdownORB()
        log.end(self._handler)
        Manager._manager = None

    def shutdownORB(self) -> None:
        """End the ORB."""
        orb.stop()

    def join(self) -> None:
        if self._runner is not None:
            self._runner.join()

    def load(self, name: str, init_function: str) -> Any:
        """Import a module file of the load path and call its init function."""
        for folder in split(self._config.getProperty("manager.modules.load_path")):
            file = Path(folder, name if name.endswith(".py") else f"{name}.py")
            if file.is_file():
                spec = importlib.util.spec_from_file_location(file.stem, file)
                assert spec is not None
                assert spec.loader is not None
                module = importlib.util.module_from_spec(spec)
                sys.modules[file.stem] = module
                spec.loader.exec_module(module)
                getattr(module, init_function)(self)
                return RTC.RTC_OK
        return RTC.RTC_ERROR

    def registerFactory(
        self,
        profile: Properties,
        new_func: Callable[[Any], Any],
        delete_func: Callable[[Any], None],
    ) -> bool:
        name = profile.getProperty("implementation_id")
        if not name or name in self._factories:
            return False
        self._factories[name] = Factory(profile, new_func)
        return True

    def createComponent(self, comp_args: str) -> Any:
        """Create a component by `Name?key=value&...`; the properties stay in the factory's profile.

        Returns None if there is no such factory or the component did not initialize; an existing
        component of the instance name if that is configured.
        """
        name, _, query = comp_args.partition("?")
        factory = self._factories.get(name.strip())
        if factory is None:
            return None
        asked = dict(_pairs(query))
        there = self.getComponent(asked.get("instance_name", ""))
        if there is not None:
            return there
        profile = factory.profile
        for key in INHERITED:
            profile.setProperty(key, self._config.getProperty(key))
        for key, value in asked.items():
            profile.setProperty(key, value)
        component = factory.new(self)
        self._configure(component, factory)
        if component.initialize() != RTC.RTC_OK:
            factory.release(component)
            component.finalize()
            return None
        self._components[component.getInstanceName()] = component
        for name in self._names(component):
            self._naming.bindObject(name, component.getObjRef())
        return component

    def _configure(self, component: Any, factory: Factory) -> None:
        """Apply the profile, then the .conf file and settings of the type, then of the instance."""
        properties = Properties(factory.profile)
        number = factory.take(component)
        kind = properties.getProperty("type_name")
        instance = properties.getProperty("instance_name") or f"{kind}{number}"
        category = properties.getProperty("category")
        for name in (kind, instance):
            node = self._config.findNode(f"{category}.{name}")
            if node is None:
                continue
            file = node.getProperty("config_file")
            if file and Path(file).is_file():
                with Path(file).open(encoding="utf-8") as lines:
                    properties.load(lines)
            properties.mergeProperties(node)
        properties.setProperty("instance_name", instance)
        component.setProperties(properties)

    def _names(self, component: Any) -> list[str]:
        properties = component.getProperties()
        manager = self._config.getProperty("manager.instance_name")
        return [
            formatted(pattern, properties, manager)
            for pattern in split(properties.getProperty("naming.formats"))
        ]

    def notifyFinalized(self, component: Any) -> None:
        """Remove an ended component; without any, the process ends as well."""
        for name in self._names(component):
            self._naming.unbindObject(name)
        self._components.pop(component.getInstanceName(), None)
        for factory in self._factories.values():
            factory.release(component)
        if not self._components and toBool(
            self._config.getProperty("manager.shutdown_on_nortcs"), "YES", "NO", True
        ):
            self.terminate()

    def getComponents(self) -> list[Any]:
        return list(self._components.values())

    def getComponent(self, instance_name: str) -> Any:
        return self._components.get(instance_name)

    def deleteComponent(self, instance_name: str) -> None:
        component = self.getComponent(instance_name)
        if component is not None:
            component.exit()

    def _connect(self, text: str) -> None:
        """Connect by `A0.out?port=B0.in&dataflow_type=push&...`."""
        first, _, query = text.partition("?")
        properties, ports = Properties(), [first.strip()]
        for key, value in _pairs(query):
            if re.fullmatch(r"port\d*", key):
                ports.append(value)
            else:
                properties.setProperty(f"dataport.{key}", value)
        found = [self._port(name) for name in ports]
        for other in found[1:]:
            CORBA_RTCUtil.connect(text, properties, found[0], other)

    def _port(self, name: str) -> Any:
        component = self.getComponent(name.partition(".")[0])
        if component is None:
            return None
        return CORBA_RTCUtil.get_port_by_name(component.getObjRef(), name)


def _pairs(query: str) -> list[tuple[str, str]]:
    parts = [each.partition("=") for each in query.split("&") if each]
    return [(key.strip(), value.strip()) for key, _, value in parts]
