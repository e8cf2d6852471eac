"""Back end for adapters: generates their modules."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from rtgen.backends import Artifact, Emission, Options
from rtgen.backends.components.imports import Imports
from rtgen.backends.components.locations import base_location, source_of
from rtgen.backends.kit.python_module import (
    PythonModule,
    imports_from,
    python_module,
)
from rtgen.backends.kit.quoting.python import docstring, number_literal, string_literal
from rtgen.facts.adapter_constants import AdapterConstant
from rtgen.model import (
    Adapter,
    ArrayType,
    Component,
    Model,
    NamedType,
    ScopedName,
    SequenceType,
    Struct,
    Type,
)
from rtgen.typemap.python.idl_names import PythonNames
from rtgen.typemap.python.names import module_name

_METHODS = frozenset({"annotations", "ec_id", "int", "made", "sample", "self"})
_CONVERSIONS = "rtgen.runtime.ros2.conversions"
_RUNTIME = ("RTC_OK", "ReturnCode_t")


class AdaptersBackend:
    """Generates a module for each adapter."""

    name = "adapters"

    def emit(self, model: Model, options: Options) -> Emission:
        """Return the modules of all adapters. The model has been checked."""
        return Emission(tuple(_artifacts(model, options)))


BACKEND = AdaptersBackend()


def _artifacts(model: Model, options: Options) -> Iterator[Artifact]:
    names = PythonNames(model, options.package)
    for number, adapter in enumerate(model.adapters):
        component = model.find((adapter.name,))
        assert isinstance(component, Component)
        source = source_of(model, component)
        origin = [source.key]
        if number == 0:
            yield python_module(
                f"{options.folder}/adapters/__init__.py",
                options.package,
                options.version,
                origin,
                "Adapters between data types.",
                plain=True,
            )
        yield _module(model, names, adapter, component, options, origin)


def _module(
    model: Model,
    names: PythonNames,
    adapter: Adapter,
    component: Component,
    options: Options,
    origin: Sequence[str],
) -> PythonModule:
    base = f"{adapter.name}Base"
    taken = {adapter.name, base, *_METHODS, *_RUNTIME, adapter.conversion}
    types = Imports(model, names, taken)
    made = types.type_name(adapter.target)
    body = [
        f"class {adapter.name}({base}):",
        docstring(_doc(adapter), 4),
        "    def on_execute(self, ec_id: int) -> ReturnCode_t:",
        '        """Convert everything that has come."""',
        "        while self.input.is_new() and (sample := self.input.read()) is not None:",
        f"            made = {made}()",
        *_copied(model, names, types, adapter),
        *_converted(adapter),
        *(
            f"            made.{_path(model, names, adapter.target, to)} ="
            f" {_literal(value)}"
            for to, value in adapter.constants
        ),
        "            self.output.write(made)",
        "        return RTC_OK",
    ]
    converting = [adapter.conversion] if adapter.conversion else []
    return python_module(
        f"{options.folder}/adapters/{module_name(adapter.name)}.py",
        options.package,
        options.version,
        origin,
        f"{adapter.name}: {_doc(adapter)}",
        imports=[
            *imports_from("rtgen.runtime", _RUNTIME),
            *imports_from(_CONVERSIONS, converting),
            *imports_from(base_location(options.package, component), [base]),
            *types.imports(),
        ],
        body="\n".join(body),
    )


def _copied(
    model: Model, names: PythonNames, types: Imports, adapter: Adapter
) -> Iterator[str]:
    scales = {to: scale for to, *scale in adapter.scales}
    for to, source in adapter.copies:
        value = f"sample.{_path(model, names, adapter.source, source)}"
        if to in scales:
            type_ = _type(model, adapter.target, to)
            value = _scaled(value, scales[to], model, types, type_)
        yield f"            made.{_path(model, names, adapter.target, to)} = {value}"


def _scaled(
    value: str,
    scale: Sequence[float],
    model: Model,
    types: Imports,
    type_: Type,
    depth: int = 0,
) -> str:
    """Return the expression of a converted number, or of a type's converted numbers."""
    if not isinstance(type_, SequenceType | ArrayType):
        return _scaled_number(value, *scale)
    if type_.numeric == "numpy":
        array, item = f"{types.spell('numpy', 'numpy')}.asarray", types.mapping.item(
            type_
        )
        return f"{array}({_scaled_number(f'{array}({value}, {item})', *scale)}, {item})"
    element = model.unalias(type_.element)
    if isinstance(type_, ArrayType) and len(type_.dimensions) > 1:
        element = replace(type_, dimensions=type_.dimensions[1:])
    each = f"each{depth or ''}"
    return f"[{_scaled(each, scale, model, types, element, depth + 1)} for {each} in {value}]"


def _scaled_number(value: str, factor: float, offset: float) -> str:
    made = value if factor == 1 else f"{number_literal(factor)} * {value}"
    if offset:
        made += f" {'-' if offset < 0 else '+'} {number_literal(abs(offset))}"
    return made


def _type(model: Model, struct: ScopedName, path: tuple[str, ...]) -> Type:
    """Return the type of a member, without aliases."""
    declaration = model.find(struct)
    assert isinstance(declaration, Struct)
    own = {member.name: model.unalias(member.type) for member in declaration.members}
    name, *rest = path
    if name not in own:
        assert declaration.base is not None
        return _type(model, declaration.base, path)
    type_ = own[name]
    if rest:
        assert isinstance(type_, NamedType)
        return _type(model, type_.name, tuple(rest))
    return type_


def _converted(adapter: Adapter) -> Iterator[str]:
    if adapter.conversion:
        yield f"            {adapter.conversion}(sample, made)"
    if adapter.stamps:
        yield "            self.stamp(made)"


def _literal(value: AdapterConstant) -> str:
    if isinstance(value, str):
        return string_literal(value)
    if isinstance(value, tuple):
        return f"[{', '.join(map(string_literal, value))}]"
    return number_literal(value)


def _doc(adapter: Adapter) -> str:
    return f"Makes {'::'.join(adapter.target)} of {'::'.join(adapter.source)}."


def _path(
    model: Model, names: PythonNames, struct: ScopedName, path: tuple[str, ...]
) -> str:
    """Return a path of members by their Python names."""
    name, *rest = path
    declaration = model.find(struct)
    assert isinstance(declaration, Struct)
    own = {member.name: model.unalias(member.type) for member in declaration.members}
    if name not in own:
        assert declaration.base is not None
        return _path(model, names, declaration.base, path)
    spelled = names.members(declaration)[name]
    type_ = own[name]
    if not rest:
        return spelled
    assert isinstance(type_, NamedType)
    return f"{spelled}.{_path(model, names, type_.name, tuple(rest))}"
