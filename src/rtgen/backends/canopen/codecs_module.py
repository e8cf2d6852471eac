"""The module `codecs` of a device: its PDOs in octets."""

from __future__ import annotations

from rtgen.backends.canopen.pdo_codec import PdoCodec, module_text
from rtgen.backends.quoting.python import docstring
from rtgen.typemap.canopen_ports import DevicePorts


def codecs_text(ports: DevicePorts, header: str) -> str:
    """The module."""
    codecs = [
        PdoCodec(s.name, f"{s.pdo.direction.upper()} {s.pdo.number}", s.layout)
        for s in ports.samples
    ]
    return (
        header
        + docstring(f"The PDOs of `{ports.device.key}`.", 0)
        + "\n"
        + (module_text(codecs) if codecs else "")
    ).rstrip("\n") + "\n"
