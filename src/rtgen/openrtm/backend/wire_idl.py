"""Prints classic IDL from the model, for omniidl to compile."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from functools import cached_property

from msgspec.structs import replace

from rtgen.compiler.backends import Artifact
from rtgen.compiler.backends.kit.idl_text import idl_text
from rtgen.compiler.backends.kit.python_text import header, header_comment
from rtgen.compiler.backends.kit.rendering import render
from rtgen.compiler.diagnostics import Diagnostic
from rtgen.compiler.model import (
    Component,
    Declaration,
    Home,
    Member,
    Model,
    Primitive,
    PrimitiveType,
    Struct,
)
from rtgen.compiler.model.declarations import OPAQUE
from rtgen.facts import python_modules
from rtgen.facts.omniidl import STAND_IN, opaque_id
from rtgen.openrtm.backend import rules
from rtgen.openrtm.backend.classic import Classic
from rtgen.openrtm.backend.plan import ComponentPlan, IdlFile, Unit


class WireIdl:
    """Prints the IDL files of a package.

    `project_modules` are the project's top-level modules of Python.
    """

    def __init__(self, unit: Unit, project_modules: Container[str] = ()) -> None:
        self._unit = unit
        self._classic = Classic(unit.model)
        self._project_modules = project_modules
        self._examined: set[str] = set()

    def artifacts(self, plan: ComponentPlan) -> Iterator[Artifact]:
        """Yield a component's IDL files except OpenRTM's own, and the script to compile them."""
        for file in plan.own_idl_files:
            sources = [f for f in self._unit.model.files if f.name in file.files]
            keys = tuple(dict.fromkeys(source.key for source in sources))
            path = f"{plan.folder}/idl/{file.stem}.idl"
            yield Artifact(path, self.text(file), keys)
        source = plan.source
        version = self._unit.options.version
        values = {
            "name": plan.name,
            "own": [file.stem for file in plan.own_idl_files],
            "stock": [file.stem for file in plan.idl_files if file.stock],
            "loose": self._unit.options.ignore_case_clashes,
        }
        for name, head in (
            ("idlcompile.sh", header_comment(version, [source.key])),
            ("idlcompile.bat", header(version, [source.key])),
        ):
            text = render(f"openrtm/{name}.j2", header=head, **values)
            yield Artifact(f"{plan.folder}/{name}", text, (source.key,))

    def findings(self, plan: ComponentPlan) -> Iterator[Diagnostic]:
        """Yield diagnostics for port types without classic IDL, and for hidden Python modules.

        IDL modules can hide those of Python.
        """
        data = [(port.port, port.type) for port in (*plan.in_ports, *plan.out_ports)]
        services = [
            (interface.port, interface.type)
            for port in plan.service_ports
            for interface in port.interfaces
        ]
        for port, type_ in (*data, *services):
            reason = self._classic.reason(type_.name)
            if reason:
                message = f"OpenRTM cannot have the port `{port.name}`: {reason}"
                yield rules.NOT_CLASSIC.at(port.span, message)
        yield from self._modules_of_python(plan)

    def _modules_of_python(self, plan: ComponentPlan) -> Iterator[Diagnostic]:
        """Yield a finding at the first declaration of each such IDL module."""
        files = {path for file in plan.own_idl_files for path in file.files}
        for declaration in self._unit.model.declarations:
            module = declaration.name[0]
            if (
                declaration.file not in files
                or len(declaration.name) == 1
                or module in self._examined
            ):
                continue
            self._examined.add(module)
            place = f"`{declaration.scoped}` is in the module `{module}`"
            owner = python_modules.owner(module)
            if module in self._project_modules:
                yield rules.PROJECT_MODULE.at(
                    declaration.span,
                    f"{place}: its stubs would hide the project's module of that name",
                )
            elif owner and module not in python_modules.MIDDLEWARE:
                yield rules.PYTHON_MODULE.at(
                    declaration.span,
                    f"{place}: omniORB may put it into the module of that name of {owner}",
                )

    def text(self, file: IdlFile) -> str:
        """Return the text of a file, with includes of its dependencies."""
        sources = [f for f in self._unit.model.files if f.name in file.files]
        keys = [source.key for source in sources]
        head = "".join(
            f"// {line}\n" for line in header(self._unit.options.version, keys)
        )
        macro = f"RTGEN_{file.stem.upper()}_IDL"
        includes = "".join(
            f'#include "{needed.stem}.idl"\n' for needed in self._unit.needs(file)
        )
        body = idl_text(
            self._model,
            [d for d in self._model.declarations if d.file in file.files],
            annotations=False,
        )
        parts = (
            f"#ifndef {macro}\n#define {macro}\n",
            includes,
            body,
            f"#endif // {macro}\n",
        )
        return head + "\n" + "\n".join(part for part in parts if part)

    @cached_property
    def _model(self) -> Model:
        """The model restricted to classic IDL, with inherited members copied into structs."""
        return replace(
            self._unit.model,
            declarations=tuple(self._classic_ones(self._unit.model.declarations)),
        )

    def _classic_ones(
        self, declarations: Iterable[Declaration]
    ) -> Iterator[Declaration]:
        for declaration in declarations:
            if isinstance(declaration, Component | Home):
                continue
            if self._classic.reason(declaration.name):
                continue
            if not isinstance(declaration, Struct):
                yield declaration
            elif declaration.annotation(OPAQUE) is not None:
                octet = PrimitiveType(Primitive.OCTET)
                member = Member(name=STAND_IN, type=octet, span=declaration.span)
                id_ = opaque_id(declaration.scoped)
                yield replace(declaration, repository_id=id_, members=(member,))
            else:
                members = self._unit.model.members(declaration)
                yield replace(declaration, base=None, members=tuple(members))
