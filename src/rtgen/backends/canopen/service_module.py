"""The module `service`: the servant of the SDO service, shared by all proxies of a project."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.backends import Options
from rtgen.backends.components.imports import Imports
from rtgen.backends.python_text import fit_text
from rtgen.backends.quoting.python import docstring
from rtgen.lowering.canopen.kinds import OBJECT_DICTIONARY
from rtgen.model import Interface, Model
from rtgen.typemap.idl_python_names import PythonNames

SERVANT = "ObjectService"

_TAKEN = frozenset(
    {SERVANT, "ProxyHooks", "SdoAccess", "annotations", "bytes", "int", "self", "super"}
    | {"index", "kind", "proxy", "subindex", "value"}
)


def service_text(
    model: Model, names: PythonNames, options: Options, header: str
) -> str:
    """The module."""
    types = Imports(model, names, "..", _TAKEN, options.external)
    body = list(_servant(model, names, types))
    head = [
        "from __future__ import annotations",
        "",
        "from rtgen.runtime.canopen.hooks import ProxyHooks",
        "from rtgen.runtime.canopen.master.sdo_service import SdoAccess",
        "",
        *types.lines(),
        "",
        "",
    ]
    title = docstring("The objects of CANopen devices as a service.", 0)
    return fit_text(f"{header}{title}\n" + "\n".join([*head, *body]) + "\n")


def _servant(model: Model, names: PythonNames, types: Imports) -> Iterator[str]:
    interface = model.find(OBJECT_DICTIONARY)
    assert isinstance(interface, Interface)
    methods = names.operations(interface)
    aborted = types.type_name(("CANopen", "SdoAbort"))
    gone = types.type_name(("CANopen", "BusGone"))
    value = types.type_name(("CANopen", "ObjectValue"))
    kind = types.type_name(("CANopen", "ValueKind"))
    place = "self, index: int, subindex: int"
    yield f"class {SERVANT}({types.type_name(OBJECT_DICTIONARY)}):"
    yield '    """The objects of the device of a proxy, by SDO."""'
    yield ""
    yield "    def __init__(self, proxy: ProxyHooks) -> None:"
    yield f"        self._access = SdoAccess(proxy, {aborted}, {gone})"
    yield ""
    yield f"    def {methods['read']}({place}) -> bytes:"
    yield "        return self._access.read(index, subindex)"
    yield ""
    yield f"    def {methods['write']}({place}, value: bytes) -> None:"
    yield "        self._access.write(index, subindex, value)"
    yield ""
    yield f"    def {methods['get']}({place}) -> {value}:"
    yield "        kind, value = self._access.typed(index, subindex)"
    yield f"        return {value}({kind}(kind), value)"
    yield ""
    yield f"    def {methods['set']}({place}, value: {value}) -> None:"
    yield "        self._access.set(index, subindex, value.value)"
