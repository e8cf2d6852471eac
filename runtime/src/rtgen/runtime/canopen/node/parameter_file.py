"""A file with a device's stored parameters (objects 1010h and 1011h).

The file is JSON: `format`, the device (`device`, `vendor`, `product`, `revision`), and `values`,
the octets of each stored object in hexadecimal digits by its number (`6083:0`). A file of another
device, or a damaged one, is rejected and never overwritten.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from rtgen.facts.files import read_start, write_atomically
from rtgen.runtime.canopen import values
from rtgen.runtime.canopen.description import DeviceDescription, ObjectNumber

FORMAT: Final = "rtgen-canopen-parameters/1"
SUFFIX: Final = ".json"
_MAX_BYTES: Final = 1 << 20
"""Maximum size of a file in octets."""


class ParameterFileError(ValueError):
    """A parameter file that cannot be used; the message names it."""


class ParameterFile:
    """The parameter file of a device.

    `name` is relative to the working folder and must be below it, so that its source (such as a
    system file) cannot refer to other files. Raises ParameterFileError.
    """

    def __init__(self, name: str, description: DeviceDescription) -> None:
        self._name = name
        self._description = description
        path, folder = Path(name), Path.cwd()
        if path.is_absolute() or path.drive or ".." in path.parts:
            raise self._error("give a path below the working folder")
        if path.suffix != SUFFIX:
            raise self._error(f"the name must end in {SUFFIX}")
        self._path = folder / path
        if not self._path.resolve().is_relative_to(folder.resolve()):
            raise self._error("it leads out of the working folder")

    def read(self) -> dict[ObjectNumber, bytes]:
        """Return the stored values; none if there is no file yet. Raises ParameterFileError."""
        try:
            text = read_start(self._path, _MAX_BYTES + 1)
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise self._error(error.strerror or str(error)) from None
        if len(text) > _MAX_BYTES:
            raise self._error(f"over {_MAX_BYTES} octets are not stored parameters")
        try:
            content = json.loads(text)
        except (ValueError, RecursionError):
            raise self._error("this is not JSON, or not all of it") from None
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise self._error(f"these are not stored parameters ({FORMAT})")
        head = self._head()
        for key, ours in head.items():
            if content.get(key) != ours:
                theirs = str(content.get(key))[:40]
                raise self._error(
                    f"parameters of another device: {key} {theirs}, not {ours}"
                )
        return self._values(content.get("values"))

    def write(self, stored: Mapping[ObjectNumber, bytes]) -> None:
        """Replace the file atomically: after a failure it is unchanged. Raises OSError."""
        content = self._head() | {
            "values": {
                f"{index:04X}:{subindex:X}": octets.hex()
                for (index, subindex), octets in sorted(stored.items())
            }
        }
        text = json.dumps(content, indent=1) + "\n"
        write_atomically(self._path, text.encode("ascii"), durable=True)

    def _head(self) -> dict[str, Any]:
        device = self._description
        return {
            "format": FORMAT,
            "device": device.name,
            "vendor": device.vendor_id,
            "product": device.product_code,
            "revision": device.revision_number,
        }

    def _values(self, content: object) -> dict[ObjectNumber, bytes]:
        if not isinstance(content, dict):
            raise self._error("it has no values")
        numbers = {
            f"{o.index:04X}:{o.subindex:X}": o for o in self._description.objects
        }
        stored: dict[ObjectNumber, bytes] = {}
        for key, digits in content.items():
            described = numbers.get(key)
            if described is None or not described.writable:
                raise self._error(f"no object {key[:20]!r} can be stored")
            try:
                octets = bytes.fromhex(digits)
                value = values.decode(described.kind, octets)
                values.checked(described.kind, value, described.low, described.high)
            except (TypeError, ValueError):
                excerpt = str(digits)[:40]
                raise self._error(f"{key} cannot have the octets {excerpt!r}") from None
            stored[described.index, described.subindex] = octets
        return stored

    def _error(self, message: str) -> ParameterFileError:
        return ParameterFileError(f"{self._name}: {message}")
