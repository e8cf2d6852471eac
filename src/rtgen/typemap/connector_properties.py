"""Properties of connectors by OpenRTM's names: which there are, and which values they take."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from math import isfinite

SUBSCRIPTIONS = ("flush", "new", "periodic")
OWN_PORT = "rtgen.own_port"
"""rtgen's property of a connector with an end, `INSTANCE.PORT`, that no definition has: a behaviour
makes the port itself."""

OVERRIDE = "rtgen.openrtm."
"""What stands before a property that is meant for the target openrtm alone."""

STRICTNESS = "port.connection.strictness"

_ENDS = ("", "inport.", "outport.")
_ADDRESS_PREFIX = "dataport.corba_cdr."
_PREFIXES = ("dataport.", "port.")
_INTEGER = re.compile(r"[0-9]{1,18}")

Value = Callable[[str], str | None]
"""What a property wants to be, where a text is not that; else None."""


def _one_of(*words: str) -> Value:
    wanted = " or ".join(words)
    return lambda text: None if text in words else wanted


def _integer(minimum: int) -> Value:
    def check(text: str) -> str | None:
        if _INTEGER.fullmatch(text) and int(text) >= minimum:
            return None
        return f"an integer, at least {minimum}"

    return check


def _number(wanted: str, *, positive: bool) -> Value:
    def check(text: str) -> str | None:
        try:
            value = float(text)
        except ValueError:
            return wanted
        fits = isfinite(value) and (value > 0 if positive else value >= 0)
        return None if fits else wanted

    return check


def _flag(text: str) -> str | None:
    return None if text.upper() in ("YES", "NO") else "YES or NO"


def _byte_orders(text: str) -> str | None:
    known = all(order.strip() in ("little", "big") for order in text.split(","))
    return None if known else "little or big, in order of wish"


def _text(_: str) -> None:
    return None


_SECONDS = _number("a time in seconds, 0 or more", positive=False)
_OF_BUFFERS: Mapping[str, Value] = {
    "length": _integer(1),
    "write.full_policy": _one_of("overwrite", "do_nothing", "block"),
    "write.timeout": _SECONDS,
    "read.empty_policy": _one_of("readback", "do_nothing", "block"),
    "read.timeout": _SECONDS,
}

DATA: Mapping[str, Value] = {
    "dataport.interface_type": _one_of(
        "corba_cdr", "direct", "shared_memory", "data_service", "csp_channel"
    ),
    "dataport.dataflow_type": _one_of("push", "pull", "duplex"),
    "dataport.subscription_type": _one_of(*SUBSCRIPTIONS),
    "dataport.io_mode": _one_of("block", "nonblock", *SUBSCRIPTIONS),
    **{f"dataport.{end}data_type": _text for end in _ENDS},
    "dataport.publisher.push_policy": _one_of("all", "fifo", "skip", "new"),
    "dataport.publisher.skip_count": _integer(0),
    "dataport.publisher.push_rate": _number("a rate in Hz, above 0", positive=True),
    **{
        f"dataport.{end}buffer.{key}": value
        for end in _ENDS
        for key, value in _OF_BUFFERS.items()
    },
    "dataport.serializer.cdr.endian": _byte_orders,
    **{f"dataport.{end}marshaling_type": _one_of("cdr") for end in _ENDS},
    "dataport.fan_in": _integer(1),
    "dataport.fan_out": _integer(1),
    "dataport.allow_dup_connection": _flag,
}
"""Those of data connectors."""

SERVICE: Mapping[str, Value] = {STRICTNESS: _one_of("strict", "best_effort")}
"""Those of service connectors, beside the pairs of interfaces."""


def table(*, service: bool) -> Mapping[str, Value]:
    """The properties of service connectors, or of data connectors."""
    return SERVICE if service else DATA


def is_pair(key: str) -> bool:
    """Whether a property of a service connector tells a consumer its provider."""
    return ".required." in key


def own_properties(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Those of OpenRTM among the properties of a connector in a file."""
    return {key: text for key, text in pairs if not is_foreign(key)}


def is_foreign(key: str) -> bool:
    """Whether a property is none of OpenRTM's: an editor's own, or an address it has saved."""
    own = key.startswith(_PREFIXES) or is_pair(key)
    return not own or key.startswith(_ADDRESS_PREFIX)
