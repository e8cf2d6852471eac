"""Configuration of a manager: defaults, configuration file, command line."""

from __future__ import annotations

import getopt
import os
import sys
import traceback
from pathlib import Path

from .properties import Properties

DEFAULTS = {
    "config.version": "2.1",
    "openrtm.name": "OpenRTM-aist-Python",
    "openrtm.version": "2.1.0",
    "manager.name": "manager",
    "manager.instance_name": "manager",
    "manager.is_master": "NO",
    "manager.shutdown_on_nortcs": "YES",
    "manager.shutdown_auto": "YES",
    "manager.modules.load_path": "./",
    "manager.components.naming_policy": "process_unique",
    "corba.nameservers": "localhost",
    "corba.endpoints": "all",
    "corba.args": "-ORBclientCallTimeOutPeriod 10000 -ORBscanGranularity 0",
    "exec_cxt.periodic.type": "PeriodicExecutionContext",
    "exec_cxt.periodic.rate": "1000",
    "exec_cxt.sync_transition": "YES",
    "exec_cxt.transition_timeout": "0.5",
    "logger.enable": "YES",
    "logger.log_level": "INFO",
    "logger.file_name": "./rtc%p.log",
    "naming.enable": "YES",
    "naming.type": "corba",
    "naming.formats": "%h.host_cxt/%n.rtc",
    "naming.update.enable": "YES",
    "naming.update.interval": "10.0",
}
PLACES = (
    "./rtc.conf",
    "/etc/rtc.conf",
    "/etc/rtc/rtc.conf",
    "/usr/local/etc/rtc.conf",
    "/usr/local/etc/rtc/rtc.conf",
)
INHERITED = (
    "config.version",
    "openrtm.name",
    "openrtm.version",
    "exec_cxt.periodic.type",
    "exec_cxt.periodic.rate",
    "exec_cxt.sync_transition",
    "exec_cxt.transition_timeout",
    "logger.enable",
    "logger.log_level",
    "naming.enable",
    "naming.type",
    "naming.formats",
)
"""Properties that a manager copies into every component, over the component's own."""


def configuration(argv: list[str]) -> Properties:
    """Return the settings of a manager that is started with a command line."""
    options = _options(argv)
    config = Properties()
    for key, value in DEFAULTS.items():
        config.setProperty(key, value)
    file = _file(options)
    if file is not None:
        with file.open(encoding="utf-8") as lines:
            config.load(lines)
        config.setProperty("config_file", str(file))
    for option, value in options:
        if option == "-o":
            key, colon, text = value.partition(":")
            if colon:
                config.setProperty(key.strip(), text.strip())
        elif option == "-d":
            config.setProperty("manager.is_master", "YES")
        elif option == "-p":
            config.setProperty("corba.endpoints", f":{value}")
        elif option == "-a":
            config.setProperty("manager.corba_servant", "NO")
    return config


def _options(argv: list[str]) -> list[tuple[str, str]]:
    """Return the options; none at all if one of them is unknown."""
    try:
        return getopt.getopt(argv[1:], "adif:o:p:")[0]
    except getopt.GetoptError:
        traceback.print_exc()
        return []


def _file(options: list[tuple[str, str]]) -> Path | None:
    named = [value for option, value in options if option == "-f"]
    if named:
        file = Path(named[-1])
        if not file.exists() and ("-i", "") not in options:
            sys.exit(f"{file}: no such configuration file")
        return file if file.exists() else None
    places = (os.environ.get("RTC_MANAGER_CONFIG", ""), *PLACES)
    return next((Path(each) for each in places if each and Path(each).is_file()), None)


def orb_arguments(config: Properties) -> list[str]:
    """Return the end points, then `corba.args`."""
    arguments = []
    for each in config.getProperty("corba.endpoints", "all").split(","):
        place = "" if each.strip() == "all" else each.strip()
        place = place if ":" in place else f"{place}:"
        arguments += ["-ORBendPoint", f"giop:tcp:{place}"]
    return arguments + config.getProperty("corba.args").split()
