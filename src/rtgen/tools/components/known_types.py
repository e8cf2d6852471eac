"""The data types and interfaces of a project's generated code, and OpenRTM's types, by name."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

from rtgen.compiler.frontends.kit.library import VirtualFile
from rtgen.compiler.frontends.stage import Settings, read_idl
from rtgen.compiler.kit.resources import OPENRTM_IDL
from rtgen.compiler.model import Model
from rtgen.compiler.project import Project
from rtgen.compiler.typemap.data_classes import NoTypeError, Types
from rtgen.runtime.failures import log
from rtgen.runtime.marshalling.descriptors import DataType
from rtgen.runtime.services.servants import Servant

_MODULES = "_idl"
"""The packages of generated code that declare types."""


class KnownTypes:
    """Looks up types by scoped names, or by the last parts of these, like those of OpenRTM 1.

    The folders of generated code are on the import path.
    """

    def __init__(self, project: Project) -> None:
        self._package = project.output / project.options.folder
        self._root = project.output
        self._data_types: dict[str, type[DataType] | None] = {}

    def data_type(self, name: str) -> type[DataType] | None:
        """Return a type by name; None if neither the project nor OpenRTM's IDL declares it."""
        class_: type[DataType] | None = self._class(name)
        if class_ is None or issubclass(class_, Servant):
            return self._shipped(name)
        return class_

    def interface(self, name: str) -> type[Servant] | None:
        """Return an interface by name; None if the project does not declare it."""
        class_ = self._class(name)
        is_interface = class_ is not None and issubclass(class_, Servant)
        return class_ if is_interface else None

    def _class(self, name: str) -> type[Any] | None:
        return self._classes.get(name, self._classes.get(_last(name)))

    @cached_property
    def _classes(self) -> dict[str, Any]:
        classes: dict[str, Any] = {}
        for class_ in self._declared():
            name = class_._descriptor_.name
            classes[name] = class_
            classes.setdefault(_last(name), class_)
        return classes

    def _declared(self) -> Iterator[Any]:
        for path in sorted(self._package.glob(f"**/{_MODULES}/*.py")):
            module = ".".join(path.relative_to(self._root).with_suffix("").parts)
            try:
                values = vars(import_module(module)).values()
            except ImportError as error:
                log.warning("the types of %s are unknown: %s", module, error)
                continue
            for value in values:
                if isinstance(value, type) and "_descriptor_" in vars(value):
                    yield value

    def _shipped(self, name: str) -> type[DataType] | None:
        if name not in self._data_types:
            self._data_types[name] = self._make(name)
        return self._data_types[name]

    def _make(self, name: str) -> type[DataType] | None:
        names = {"::".join(each.name): each.name for each in self._openrtm.declarations}
        scoped = names.get(name, names.get(f"RTC::{name}"))
        if scoped is None:
            return None
        try:
            descriptor: Any = Types(self._openrtm).named(scoped)
        except NoTypeError:
            return None
        class_: type[DataType] | None = getattr(descriptor, "class_", None)
        return class_

    @cached_property
    def _openrtm(self) -> Model:
        text = "".join(f'#include "{name}"\n' for name in OPENRTM_IDL)
        file = VirtualFile("openrtm.idl", text, given=True)
        return read_idl((), Settings(root=Path()), text=file).model


def _last(name: str) -> str:
    return name.rpartition("::")[2]
