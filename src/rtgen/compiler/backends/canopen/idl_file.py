"""The IDL file of a device, for definitions that include it and for other IDL compilers."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial

from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.lowering.canopen.kinds import file_name, kinds_of
from rtgen.compiler.lowering.canopen.types import declarations
from rtgen.compiler.model import Model
from rtgen.compiler.typemap.canopen.labels import line
from rtgen.compiler.typemap.canopen.ports import DevicePorts


def idl_of(ports: DevicePorts) -> str:
    """Return the text of the IDL file of a device, without its components."""
    macro = re.sub(r"[^A-Za-z0-9]", "_", f"{ports.kind.module}_IDL")
    macro = f"CANOPEN_{macro.upper()}"
    made = tuple(declarations(ports))
    body = idl_text(Model(declarations=made), made, annotations=False)
    info = ports.device.info
    about = " ".join(filter(None, (info.vendor_name, info.product_name)))
    title = f"// {line(about)}\n" if about else ""
    return (
        f"{title}\n#ifndef {macro}\n#define {macro}\n\n"
        f'#include "BasicDataType.idl"\n#include "Canopen.idl"\n\n'
        f"{body}\n#endif // {macro}\n"
    )


def idl_files(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of the files of all devices, by the name that includes them."""
    kinds, _ = kinds_of(model.devices, model.buses)
    devices = (DevicePorts(kind.device, kind) for kind in kinds)
    return {file_name(ports): partial(idl_of, ports) for ports in devices}
