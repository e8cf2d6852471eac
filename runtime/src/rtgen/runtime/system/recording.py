"""Writes events of a system as JSON lines, deterministically in simulated time."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from typing import Any, TextIO

from rtgen.runtime.marshalling.dynamic.faults import encoding_error
from rtgen.runtime.marshalling.errors import FAILURES
from rtgen.runtime.ports.data_ports import OutPort
from rtgen.runtime.system.json_printers import json_printer, plain
from rtgen.runtime.system.records import MissingSamples, Record, SampleRecord


class JsonLinesRecorder:
    """A listener that writes one JSON object for each record to a text stream.

    States: `{"t", "event": "state", "instance", "from", "to", "context"}`, and `reason` with ERROR;
    samples: `{"t", "event": "sample", "instance", "port", "value"}`. `t` in ns since the start,
    without wall time. Structs are objects, enumerators their names, octets numbers, non-finite
    floats text.
    """

    def __init__(self, stream: TextIO) -> None:
        self.missing = MissingSamples()
        self._stream = stream
        self._lock = threading.Lock()

    def __call__(self, record: Record) -> None:
        line = json.dumps(_fields(record), ensure_ascii=False) + "\n"
        with self._lock:
            self._stream.write(line)

    def sample_writer(
        self, port: OutPort[Any], elapsed: Callable[[], int]
    ) -> Callable[[Any], None]:
        """Return a writer for the samples of a port that needs no snapshot."""
        result = {"event": "sample", "instance": port.owner, "port": port.name}
        text = (
            json.dumps(result, ensure_ascii=False).removeprefix("{").removesuffix("}")
        )
        between = f', {text}, "value": '
        printed = json_printer(port.type)
        write, lock = self._stream.write, self._lock

        missing = self.missing

        def write_sample(value: Any) -> None:
            try:
                line = f'{{"t": {elapsed()}{between}{printed(value)}}}\n'
            except FAILURES as failure:
                missing.add(
                    port, encoding_error(port.type._descriptor_, value, failure)
                )
                return
            with lock:
                write(line)

        return write_sample


def _fields(record: Record) -> dict[str, Any]:
    result: dict[str, Any] = {
        "t": record.time,
        "event": record.kind,
        "instance": record.instance,
    }
    if isinstance(record, SampleRecord):
        return result | {"port": record.port, "value": plain(record.value)}
    result |= {
        "from": record.before.name,
        "to": record.after.name,
        "context": record.ec_id,
    }
    return result | ({"reason": record.reason} if record.reason else {})
