"""IDL files of ROS 2 interfaces, for definitions that include them: `std_msgs/msg/Header.idl`.

They contain the same declarations as rosidl_adapter's output.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import PurePosixPath

from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.model import Model
from rtgen.facts.ros import INTERFACE_SUFFIXES

_IDL = ".idl"


def idl_names(model: Model) -> dict[str, str]:
    """Return the interface files of a model: displayed names by the names of their IDL files."""
    names = {}
    for declaration in model.declarations:
        path = PurePosixPath(declaration.file)
        is_idl = path.suffix == _IDL and declaration.name[1:2] == (path.parent.name,)
        if path.suffix in INTERFACE_SUFFIXES or is_idl:
            name = "/".join((*declaration.name[:2], f"{path.stem}.idl"))
            names[name] = declaration.file
    return names


def idl_files(model: Model) -> dict[str, Callable[[], str]]:
    """Return the texts of the IDL files of a model's interfaces, by the name in `#include`."""
    return {name: partial(idl_of, model, name) for name in idl_names(model)}


def idl_of(model: Model, name: str) -> str:
    """Return the text of the IDL file of an interface."""
    macro = name.upper().translate(str.maketrans("/.", "__"))
    text = plain_idl_of(model, name)
    return f"#ifndef {macro}\n#define {macro}\n\n{text}\n#endif // {macro}\n"


def plain_idl_of(model: Model, name: str) -> str:
    """Return the IDL file of an interface without a guard, which rosidl does not read."""
    names = idl_names(model)
    shown = names[name]
    includes = {
        included
        for file in model.files
        if file.name == shown
        for included in file.includes
    }
    lines = [f'#include "{each}"' for each in sorted(names) if names[each] in includes]
    body = idl_text(model, [d for d in model.declarations if d.file == shown])
    head = "".join(f"{line}\n" for line in lines)
    return f"{head}\n{body}"
