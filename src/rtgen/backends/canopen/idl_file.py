"""The IDL file of a device, for definitions that include it and for other IDL compilers."""

from __future__ import annotations

import re

from rtgen.backends.idl_text import idl_text
from rtgen.lowering.canopen.types import declarations
from rtgen.model import Model
from rtgen.typemap.canopen_ports import DevicePorts
from rtgen.typemap.canopen_texts import line


def idl_of(ports: DevicePorts) -> str:
    """The text of the IDL file of a device, without its components."""
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
