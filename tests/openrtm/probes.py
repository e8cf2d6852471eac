"""Behaviours that use every port of a component, and record all input; and their start.

`python probes.py MODULE [options]` runs a generated module with a probe in place of its behaviour.
Environment variables name the behaviour (`PROBED`, `module:name`) and the file of notes
(`PROBE_NOTES`, JSON lines); a file `fail` in the working folder makes the next execution fail.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
from collections import Counter
from importlib import import_module
from pathlib import Path
from typing import Any

from specimens import COUNT, specimen

from rtgen.runtime import RTC_ERROR, RTC_OK, Component, ReturnCode_t
from rtgen.runtime.services.calls import Call, calls_of

CALLBACKS = (
    *("on_initialize", "on_finalize", "on_startup", "on_shutdown", "on_activated"),
    *("on_deactivated", "on_state_update", "on_rate_changed"),
    *("on_aborting", "on_error", "on_reset"),
)


def note(**facts: Any) -> None:
    """Add a line to the notes."""
    with Path(os.environ["PROBE_NOTES"]).open("a", encoding="utf-8") as notes:
        notes.write(json.dumps(facts) + "\n")


def fields(record: Any) -> list[Any]:
    """Return the members of a struct, in order."""
    if record is None:
        return []
    return [getattr(record, each.attribute) for each in record._descriptor_.members]


def outcomes(call: Call) -> int:
    """Return the number of outcomes of a call: its result, and its exceptions."""
    return 1 + len(call.raises)


def answer(call: Call, number: int) -> Any:
    """Return the answer of a servant to its n-th call, or raise its exception."""
    kind = number % outcomes(call)
    if kind:
        raise specimen(call.raises[kind - 1][1]._descriptor_, number)
    if call.reply is None:
        return None
    values = fields(specimen(call.reply._descriptor_, number))
    return values[0] if len(values) == 1 else tuple(values)


def octets(kind: Any, values: Any) -> str:
    """Return the body of a request or reply."""
    return "" if kind is None else kind(*values).to_cdr().hex()


def servant(interface: Any, name: str) -> Any:
    """Return a servant that records its calls."""
    calls = calls_of(interface)
    times: Counter[str] = Counter()

    def served(operation: str, arguments: tuple[object, ...]) -> object:
        call = calls[operation]
        note(
            event="served",
            port=name,
            operation=operation,
            octets=octets(call.request, arguments),
        )
        times[operation] += 1
        return answer(call, times[operation] - 1)

    return interface._stub_(served)


def call_all(consumer: Any, name: str) -> None:
    """Call each operation of a provider once for each outcome, and record the results."""
    skeleton = consumer.interface._skeleton_(consumer.object)
    for operation, call in calls_of(consumer.interface).items():
        for number in range(outcomes(call)):
            arguments: list[Any] = []
            if call.request is not None:
                arguments = fields(specimen(call.request._descriptor_, number))
            try:
                result = skeleton.dispatch(operation, tuple(arguments))
            except tuple(kind for _, kind in call.raises) as raised:
                found = [type(raised).__name__, raised.to_cdr().hex()]
            else:
                several = call.reply and len(call.reply._descriptor_.members) > 1
                values = result if several else [result]
                found = ["", octets(call.reply, values)]
            note(event="called", port=name, operation=operation, found=found)


def probe(behaviour: type[Component]) -> type[Component]:
    """Return the component with the probe's callbacks."""

    def begin(self: Any, instance_name: str | None = None) -> None:
        behaviour.__init__(self, instance_name)
        for (port, instance), provider in self.providers.items():
            provider.set_servant(servant(provider.interface, f"{port}.{instance}"))

    def on_activated(self: Any, ec_id: int) -> ReturnCode_t:
        self._probed = False
        note(event="on_activated")
        note(event="configuration", values=repr(getattr(self, "config", None)))
        return RTC_OK

    def on_execute(self: Any, ec_id: int) -> ReturnCode_t:
        for name, port in self.in_ports.items():
            while port.is_new():
                note(event="sample", port=name, octets=port.read().to_cdr().hex())
        if not self._probed:
            self._probed = True
            note(event="on_execute")
            for port in self.out_ports.values():
                for number in range(COUNT):
                    port.write(specimen(port.type._descriptor_, number))
            for (port, instance), consumer in self.consumers.items():
                if consumer.connected:
                    call_all(consumer, f"{port}.{instance}")
        if Path("fail").exists():
            Path("fail").unlink()
            return RTC_ERROR
        return RTC_OK

    own = {each: _noted(each) for each in CALLBACKS}
    own |= {
        "__init__": begin,
        "on_activated": on_activated,
        "on_execute": on_execute,
    }
    # No bus, no board: a probe is only affected over CORBA.
    own |= {
        name: getattr(Component, name) for name in ("_gate", "initialize", "finalize")
    }
    return type(behaviour.__name__, (behaviour,), own)


def _noted(name: str) -> Any:
    def callback(self: Any, *handle: int) -> ReturnCode_t:
        if name != "on_state_update":
            note(event=name)
        return RTC_OK

    return callback


def main() -> None:
    """Replace the behaviour by the probe, then run the module."""
    name, _, attribute = os.environ["PROBED"].partition(":")
    module = import_module(name)
    setattr(module, attribute, probe(getattr(module, attribute)))
    del sys.argv[0]
    runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    main()
