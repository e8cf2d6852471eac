"""The files of a project's CANopen devices and networks, in addition to their IDL."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends import Artifact, Emission, Options
from rtgen.compiler.backends.canopen.device_module import DeviceModule
from rtgen.compiler.backends.canopen.eds_text import eds_text
from rtgen.compiler.backends.canopen.idl_file import idl_of
from rtgen.compiler.backends.canopen.mirror import measured, mirrored
from rtgen.compiler.backends.canopen.network_files import network_files
from rtgen.compiler.backends.canopen.objects_module import objects_module
from rtgen.compiler.backends.canopen.proxy_module import ProxyModule
from rtgen.compiler.backends.canopen.shared_files import shared_files
from rtgen.compiler.backends.kit.python_text import header
from rtgen.compiler.lowering.canopen.kinds import file_name, kinds_of, package_of
from rtgen.compiler.model import Model
from rtgen.compiler.typemap.canopen.ports import DevicePorts
from rtgen.compiler.typemap.python.idl_names import PythonNames


class CanopenBackend:
    """Makes the tables of devices, their proxies and slaves, and a module for each network."""

    name = "canopen"

    def emit(self, model: Model, options: Options) -> Emission:
        """All files of all devices and networks. The model is checked."""
        kinds, _ = kinds_of(model.devices, model.buses)
        devices = [DevicePorts(kind.device, kind) for kind in kinds]
        if not devices:
            return Emission()
        artifacts, findings = network_files(model.buses, options)
        return Emission(
            (*_Devices(model, options).artifacts(devices), *artifacts), findings
        )


BACKEND = CanopenBackend()


class _Devices:
    def __init__(self, model: Model, options: Options) -> None:
        self._model = model
        self._options = options
        self._names = PythonNames(model, options.package)
        package = f"{options.package}.canopen.networks".removeprefix(".")
        self._networks = package if model.buses else ""

    def artifacts(self, devices: list[DevicePorts]) -> Iterator[Artifact]:
        """The files of all devices, and their shared files."""
        for ports in devices:
            yield from self._device(ports)
        yield from shared_files(self._model, self._names, self._options, self._networks)

    def _device(self, ports: DevicePorts) -> Iterator[Artifact]:
        device, module = ports.device, ports.module
        folder = f"{self._options.folder}/{package_of(ports.kind)}"
        lines = header(self._options.version, [device.key])

        def file(name: str, text: str) -> Artifact:
            return Artifact(f"{folder}/{name}", text, (device.key,))

        idl = "".join(f"// {line}\n" for line in lines)
        yield file(file_name(ports), f"{idl}\n{idl_of(ports)}")
        yield objects_module(f"{folder}/__init__.py", ports, self._options)
        whole = (self._model, self._names, ports, self._options, self._networks)
        yield ProxyModule(*whole).proxy()
        yield DeviceModule(*whole).device()
        name = f"{module}Proxy.eds"
        yield file(name, eds_text(mirrored(measured(ports), name), lines))
