"""Starts a generated module as a program, and forwards log messages to OpenRTM."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from rtgen.runtime.failures import log
from rtgen.runtime.rtc.logs import LOGGERS, instance_of

_ENDING = 5.0
"""Seconds for the threads of an ORB that was destroyed."""
_INSTANCE = "--instance_name="
_LEVELS = (
    (logging.ERROR, "RTC_ERROR"),
    (logging.WARNING, "RTC_WARN"),
    (logging.INFO, "RTC_INFO"),
)


def main(init: Callable[[Any], None], folder: Path, category: str, name: str) -> None:
    """Run a manager with one component of a module until it ends.

    `init` creates the component, of the type `name`. The arguments are those of an OpenRTM manager,
    and `--instance_name=NAME`. The configuration in the module's `folder` is used if arguments,
    environment and working folder have none. The runtime's log is also printed to standard error;
    OpenRTM's messages are in its own log only.
    """
    # A handler of the root logger would also print all messages of OpenRTM.
    log.addHandler(logging.StreamHandler())
    manager = import_module("OpenRTM_aist").Manager.init(
        arguments(sys.argv, folder, category, name)
    )
    manager.setModuleInitProc(init)
    manager.activateManager()
    manager.runManager()
    import_module("rtgen.runtime.corba.orb").await_workers(time.monotonic() + _ENDING)


def arguments(argv: list[str], folder: Path, category: str, name: str) -> list[str]:
    """Return the arguments for `Manager.init`, without rtgen's own: it stops at unknown ones."""
    remaining = [each for each in argv if not each.startswith(_INSTANCE)]
    has_file = any(each.startswith("-f") for each in remaining[1:])
    if has_file or "RTC_MANAGER_CONFIG" in os.environ or Path("rtc.conf").is_file():
        return remaining
    conf = f"{category}.{name}.config_file:{folder / name}.conf"
    return [*remaining[:1], "-f", str(folder / "rtc.conf"), "-o", conf, *remaining[1:]]


def instance_arguments(argv: list[str]) -> str:
    """Return the suffix of the type name in `createComponent` with the instance name, if any."""
    for each in argv[1:]:
        if each.startswith(_INSTANCE):
            return f"?instance_name={each.removeprefix(_INSTANCE)}"
    return ""


def behaviour_module(file: Path) -> ModuleType:
    """Import a behaviour whose module has the name of its component's module for OpenRTM.

    It becomes the module `<name>_behaviour`. Raises ImportError if there is no such file.
    """
    name = f"{file.stem}_behaviour"
    if name not in sys.modules:
        spec = spec_from_file_location(name, file)
        if spec is None or spec.loader is None or not file.is_file():
            raise ImportError(f"there is no behaviour {file.resolve()}", name=name)
        module = sys.modules[name] = module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]


class ManagerLog(logging.Handler):
    """Forwards log records of the runtime and of components to the log of OpenRTM's manager."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        manager = import_module("OpenRTM_aist").Manager.instance()
        self._out = manager.getLogbuf("rtgen")

    def emit(self, record: logging.LogRecord) -> None:
        """See `logging.Handler`."""
        write = next(name for level, name in _LEVELS if record.levelno >= level)
        instance = instance_of(record)
        text = self.format(record)
        getattr(self._out, write)("%s", f"{instance}: {text}" if instance else text)


def log_to_manager() -> None:
    """Install `ManagerLog`, once for each process."""
    if not any(isinstance(handler, ManagerLog) for handler in log.handlers):
        handler = ManagerLog()
        log.addHandler(handler)
        components = logging.getLogger(LOGGERS)
        components.setLevel(logging.INFO)
        components.addHandler(handler)
