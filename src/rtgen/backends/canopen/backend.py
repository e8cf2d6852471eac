"""Which files the CANopen devices and networks of a project give, beside those of their IDL."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.backends import Artifact, Emission, Options
from rtgen.backends.canopen.idl_model import idl_of
from rtgen.backends.canopen.kinds import file_name, folder_of, kinds_of
from rtgen.backends.python_text import header
from rtgen.model import Model
from rtgen.typemap.canopen_ports import DevicePorts


class CanopenBackend:
    """Makes a package for each kind of device, and a module for each network."""

    name = "canopen"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all devices and networks. The model is checked."""
        kinds, _ = kinds_of(model.devices, model.buses)
        devices = [DevicePorts(kind.device, kind) for kind in kinds]
        return Emission(tuple(_artifacts(model, devices, options)))


BACKEND = CanopenBackend()


def _artifacts(
    model: Model, devices: list[DevicePorts], options: Options
) -> Iterator[Artifact]:
    for ports in devices:
        folder = f"{options.folder}/canopen/{folder_of(ports.kind)}"
        origin = (ports.device.key,)
        yield Artifact(f"{folder}/{file_name(ports)}", _idl(ports, options), origin)


def _idl(ports: DevicePorts, options: Options) -> str:
    sources = [(ports.device.key, ports.device.sha256)]
    head = "".join(f"// {line}\n" for line in header(options.version, sources))
    return f"{head}\n{idl_of(ports)}"
