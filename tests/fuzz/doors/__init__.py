"""The doors: all places where octets from outside enter rtgen, each a function of octets.

A door returns whether it accepts the input, and raises for a defect only: documented exceptions for
bad input count as a refusal. `harness.py` explores doors, guided by coverage; `test_doors.py`
replays the inputs in `corpus/`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from random import Random

CORPUS = Path(__file__).parent.parent / "corpus"


@dataclass(frozen=True, slots=True)
class Door:
    """A door; `make` draws an input by the grammar of its format."""

    enter: Callable[[bytes], bool]
    make: Callable[[Random], bytes]
    seeds: Iterable[bytes] = ()


MODULES = {
    "idl": "definitions",
    "preprocessor": "definitions",
    "cdl": "definitions",
    "c-header": "definitions",
    "eds": "definitions",
    "dcf": "definitions",
    "msg": "definitions",
    "adopt": "definitions",
    "bus": "projects",
    "rtgen-toml": "projects",
    "timeline": "projects",
    "rtc-xml": "component_files",
    "rtc-yaml": "component_files",
    "rts-xml": "component_files",
    "cdr": "values",
    "xcdr1": "values",
    "xcdr2": "values",
    "type-code": "values",
    "tdr": "remote_calls",
    "rpc-server": "remote_calls",
    "rpc-client": "remote_calls",
    "rpc-script": "remote_calls",
    "giop-server": "remote_calls",
    "giop-client": "remote_calls",
    "dds-rpc-server": "remote_calls",
    "dds-rpc-client": "remote_calls",
    "sdo-server": "can",
    "sdo-client": "can",
    "pdo": "can",
    "emcy": "can",
    "lss-slave": "can",
    "lss-master": "can",
    "node": "can",
    "socketcand": "can",
    "slcan": "can",
    "mcap": "records",
    "replay": "records",
    "log": "records",
    "can-log": "records",
}
"""The module of each door, which is imported when the door is opened."""


def door(name: str, folder: Path) -> Door:
    """Open a door; it may write into the folder."""
    opened: Door = import_module(f"doors.{MODULES[name]}").DOORS[name](folder)
    return opened


def corpus(name: str) -> list[Path]:
    """Return the stored inputs of a door."""
    folder = CORPUS / name
    return sorted(folder.iterdir()) if folder.is_dir() else []


def variant(data: bytes) -> int:
    """Return a number from the octets that selects one of a door's ways to read them."""
    return sum(data[:64]) + len(data)
