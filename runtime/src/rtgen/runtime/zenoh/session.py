"""Sessions of Zenoh: the configuration that a process uses, and errors in plain words."""

from __future__ import annotations

import json
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import zenoh

from rtgen.facts.files import UnreadableError, check_file
from rtgen.runtime.distribution.key_files import check_key_file
from rtgen.runtime.distribution.medium import MediumError
from rtgen.runtime.failures import log

MEETING_PLACE = "tcp/127.0.0.1:7447"
"""Where the processes of one machine find each other, and a router of this machine, if one runs."""

_SLOW = 1.5
"""Seconds after which a session that does not open is reported."""
LEASE = 3.0
"""Seconds without a sign of life after which a process counts as lost."""

_LEASE_KEY = "transport/link/tx/lease"
"""The lease of a session in a configuration [ms], which the other ends of its links wait for."""
_FRAGMENTS_WAIT_US = 1_000_000
_TLS = "transport/link/tls"
_KEY_FILES = (
    *(f"{_TLS}/root_ca_certificate", f"{_TLS}/listen_private_key"),
    *(f"{_TLS}/listen_certificate", f"{_TLS}/connect_private_key"),
    *(f"{_TLS}/connect_certificate", "transport/auth/usrpwd/dictionary_file"),
    *(f"transport/auth/pubkey/{key}_file" for key in ("public_key", "private_key")),
    "transport/auth/pubkey/known_keys_file",
)
"""The settings of a configuration that name files."""
_FILE = "_file"
"""The end of such settings in a locator."""
_RETRY = {"period_init_ms": 100, "period_max_ms": 1000, "period_increase_factor": 2}
_CONNECT_MS = 5000
_PLACE_IN_SOURCE = re.compile(r"\s+at \S+\.rs:\d+\.?")


class Endpoints(msgspec.Struct, frozen=True, gc=False):
    """Where a session listens and connects, as locators of Zenoh (`tcp/192.0.2.1:7447`).

    `config` is a configuration file of Zenoh (JSON5, YAML), whose settings all apply; locators that
    are given replace those in the file. Without a file there is no scouting. With `connect` alone
    the session is a client of these routers, with `listen` a peer; with none of them a peer that
    meets the others at `MEETING_PLACE`, and can be reached from this machine alone. `lease`: after
    so many seconds without a sign of life others count the session as lost; it shortens `LEASE`, or
    that of the file.
    """

    config: Path | None = None
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()
    lease: float | None = None


def open_session(endpoints: Endpoints) -> zenoh.Session:
    """Open a session. Raises MediumError."""
    places = [*endpoints.connect, *endpoints.listen] or [MEETING_PLACE]
    named = endpoints.config or ", ".join(places)

    def tell() -> None:
        log.warning("Zenoh waits: nobody answers as Zenoh at %s", named)

    slow = threading.Timer(_SLOW, tell)
    slow.daemon = True
    slow.start()
    try:
        with reported(str(endpoints.config or "zenoh")):
            return zenoh.open(_configuration(endpoints))
    finally:
        slow.cancel()


def lease_of(endpoints: Endpoints) -> float:
    """The lease of a session [s]. Raises MediumError."""
    with reported(str(endpoints.config or "zenoh")):
        return _lease(_configuration(endpoints))


@contextmanager
def reported(what: str) -> Iterator[None]:
    """Raise errors of Zenoh as MediumError, without the places in its source."""
    try:
        yield
    except zenoh.ZError as error:
        raise MediumError(f"{what}: {plain(error)}") from error


def plain(error: Exception) -> str:
    """Return the message of an error of Zenoh, without the places in its source."""
    return " ".join(_PLACE_IN_SOURCE.sub("", str(error)).split()).rstrip(".")


def _configuration(endpoints: Endpoints) -> zenoh.Config:
    if endpoints.config is not None:
        config = _read(Path(endpoints.config))
        if json.loads(config.get_json("id")) is not None:
            raise MediumError(
                f"{endpoints.config} has an `id`: a process that is started again needs another "
                "one, by which readers count its samples; leave it out"
            )
        settings = {
            "connect/endpoints": endpoints.connect,
            "listen/endpoints": endpoints.listen,
        }
        _insert(config, {key: value for key, value in settings.items() if value})
    else:
        config = zenoh.Config()
        _insert(config, {**_COMMON, **_links(endpoints)})
    _check_locators(config, str(endpoints.config or "zenoh"))
    if endpoints.lease is not None and endpoints.lease < _lease(config):
        _insert(config, {_LEASE_KEY: max(1, round(endpoints.lease * 1000))})
    return config


def _read(file: Path) -> zenoh.Config:
    try:
        check_file(file)
    except UnreadableError as error:
        raise MediumError(f"{file} cannot be read: {error}") from error
    config = zenoh.Config.from_file(file)
    for key in _KEY_FILES:
        name = json.loads(config.get_json(key))
        if name is not None:
            check_key_file(str(file), key, Path(name))
    return config


def _check_locators(config: zenoh.Config, named: str) -> None:
    """Check the files that locators name: `tls/HOST:PORT#root_ca_certificate_file=PATH;..`."""
    for key in ("connect/endpoints", "listen/endpoints"):
        for locator in _texts(json.loads(config.get_json(key))):
            for setting in locator.partition("#")[2].split(";"):
                name, _, value = setting.partition("=")
                if name.endswith(_FILE):
                    check_key_file(named, name, Path(value))


def _texts(value: Any) -> Iterator[str]:
    """Yield the texts in a value of JSON: locators may be given for each mode."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, list | dict):
        for each in value.values() if isinstance(value, dict) else value:
            yield from _texts(each)


def _lease(config: zenoh.Config) -> float:
    milliseconds: int = json.loads(config.get_json(_LEASE_KEY))
    return milliseconds / 1000


_COMMON: dict[str, Any] = {
    "scouting/multicast/enabled": False,
    "scouting/delay": 0,
    "connect/retry": _RETRY,
    _LEASE_KEY: round(LEASE * 1000),
    # A sample of several megabytes is not dropped because one batch was late.
    "transport/link/tx/queue/congestion_control/drop/max_wait_before_drop_fragments": (
        _FRAGMENTS_WAIT_US
    ),
}


def _links(endpoints: Endpoints) -> dict[str, Any]:
    connect, listen = endpoints.connect, endpoints.listen
    if connect and not listen:
        return {
            "mode": "client",
            "connect/endpoints": connect,
            "connect/timeout_ms": _CONNECT_MS,
            "connect/exit_on_failure": True,
        }
    if listen:
        return {
            "mode": "peer",
            "listen/endpoints": listen,
            "connect/endpoints": connect,
            # In the background, until each of them appears; 0 would try once.
            "connect/timeout_ms": -1,
            "connect/exit_on_failure": False,
        }
    return {
        "mode": "peer",
        # The first process listens at the meeting place; when it ends another one does. Gossip
        # connects all of them directly.
        "listen/endpoints": ["tcp/127.0.0.1:0", MEETING_PLACE],
        "listen/timeout_ms": 0,
        "listen/exit_on_failure": False,
        "listen/retry": _RETRY,
        "connect/endpoints": [MEETING_PLACE],
        "connect/timeout_ms": 0,
        "connect/exit_on_failure": False,
    }


def _insert(config: zenoh.Config, values: dict[str, Any]) -> None:
    for key, value in values.items():
        config.insert_json5(key, json.dumps(value))
