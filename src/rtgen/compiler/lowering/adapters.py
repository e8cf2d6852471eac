"""Lowers the adapters of a project, `[adapter.NAME]`, to components."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Final

from msgspec.structs import replace

from rtgen.compiler.diagnostics import Diagnostic, InputError, Rule
from rtgen.compiler.kit.resources import OPENRTM_IDL, idl_source, ros_interfaces
from rtgen.compiler.lowering.adapter_rules import (
    ADAPTER_MEMBER,
    ADAPTER_NAME,
    ADAPTER_TYPE,
    ADAPTER_UNIT,
    ADAPTER_VALUE,
)
from rtgen.compiler.lowering.settings import AdapterEntry, Settings
from rtgen.compiler.lowering.stage import Lowered
from rtgen.compiler.model import (
    Adapter,
    Component,
    Member,
    Model,
    NamedType,
    Port,
    PortKind,
    Primitive,
    PrimitiveType,
    SourceFile,
    Struct,
    Type,
)
from rtgen.compiler.typemap.constant_shapes import shape_of
from rtgen.compiler.typemap.member_units import is_real, leaves, unit_of
from rtgen.compiler.typemap.python.names import module_name
from rtgen.facts.adapter_constants import AdapterConstant, shown, takes
from rtgen.facts.primitives import INTEGER_RANGES
from rtgen.facts.ros_adapters import Pair, pair_of

_NAME: Final = re.compile(r"[A-Za-z]\w*", re.ASCII)
_EXACT_INTEGERS: Final = {
    **INTEGER_RANGES,
    Primitive.FLOAT: (-(2**24), 2**24),
    Primitive.DOUBLE: (-(2**53), 2**53),
}
"""The range of integers that each floating-point type represents exactly."""


def lower(model: Model, settings: Settings) -> Lowered:
    """Return the model with the project's adapters and their components."""
    entries = settings.adapters
    if not entries:
        return Lowered(model)
    findings: list[Diagnostic] = []
    adapters: list[Adapter] = []
    components: list[Component] = []
    for entry in entries:
        try:
            maker = _Maker(model, entry)
            adapters.append(maker.adapter())
            components.append(_component(adapters[-1], *maker.units(adapters[-1])))
        except InputError as error:
            findings += error.diagnostics
    text = repr(
        [
            (a.name, a.source, a.target, a.copies)
            + ((a.conversion, a.constants) if a.conversion or a.constants else ())
            + ((a.scales,) if a.scales else ())
            for a in adapters
        ]
    )
    name = entries[0].span.file
    file = SourceFile(
        name=name, key=name, sha256=sha256(text.encode()).hexdigest(), main=True
    )
    larger = replace(
        model,
        files=(*model.files, file),
        declarations=(*model.declarations, *components),
        adapters=tuple(adapters),
    )
    return Lowered(larger, tuple(findings))


def _component(adapter: Adapter, received: str, sent: str) -> Component:
    source, target = "::".join(adapter.source), "::".join(adapter.target)
    return Component(
        name=(adapter.name,),
        repository_id=f"IDL:{adapter.name}:1.0",
        file=adapter.span.file,
        span=adapter.span,
        doc=f"Converts {source} to {target}.",
        description=f"Converts {source} to {target}",
        category="Adapters",
        vendor="rtgen",
        rate=100.0,
        max_instances=0,
        ports=(
            _port(
                adapter,
                PortKind.INPORT,
                "input",
                adapter.source,
                "What comes.",
                received,
            ),
            _port(
                adapter, PortKind.OUTPORT, "output", adapter.target, "What goes.", sent
            ),
        ),
        factory=f".adapters.{module_name(adapter.name)}:{adapter.name}",
    )


def _port(
    adapter: Adapter,
    kind: PortKind,
    name: str,
    type_: tuple[str, ...],
    doc: str,
    unit: str,
) -> Port:
    return Port(
        kind=kind,
        name=name,
        identifier=name,
        type=NamedType(type_),
        span=adapter.span,
        doc=doc,
        unit=unit,
    )


@dataclass(frozen=True)
class _Maker:
    """Makes the adapter of a table `[adapter.NAME]`."""

    model: Model
    entry: AdapterEntry

    def adapter(self) -> Adapter:
        """Return the adapter. Raises InputError."""
        entry = self.entry
        taken = any(d.name == (entry.name,) for d in self.model.declarations)
        if taken or not _NAME.fullmatch(entry.name):
            why = "there is one already" if taken else "it must be an identifier"
            raise self._error(ADAPTER_NAME, f"adapter {entry.name!r}: {why}")
        source, target = self._struct(entry.source), self._struct(entry.target)
        constants = tuple(self._constant(target, *pair) for pair in entry.constants)
        pair = pair_of(source.scoped, target.scoped)
        if pair is not None and not entry.mapping:
            return self._conversion(source, target, *pair, constants)
        copies: dict[tuple[str, ...], tuple[str, ...]] = {}
        for to, from_ in entry.mapping:
            to_path, from_path = tuple(to.split(".")), tuple(from_.split("."))
            self._check(self._type(target, to_path), self._type(source, from_path), to)
            for copy_path in copies:
                shorter = min(len(copy_path), len(to_path))
                if copy_path[:shorter] == to_path[:shorter]:
                    message = f"{to!r} and {'.'.join(copy_path)!r} fill the same member"
                    raise self._error(ADAPTER_VALUE, message)
            copies[to_path] = from_path
        targets = {path[0] for path in copies}
        theirs = {m.name: self._kind(m) for m in self.model.members(source)}
        for member in self.model.members(target):
            name = member.name
            if name not in targets and theirs.get(name) == self._kind(member):
                copies[(name,)] = (name,)
        for path in entry.units:
            self._split(copies, target, tuple(path.split(".")))
        order = [member.name for member in self.model.members(target)]
        return Adapter(
            name=entry.name,
            source=source.name,
            target=target.name,
            copies=tuple(
                sorted(copies.items(), key=lambda pair: order.index(pair[0][0]))
            ),
            span=entry.span,
            constants=constants,
            scales=tuple(
                (to, *scale)
                for to, from_ in copies.items()
                if (scale := self._scale(target, to, source, from_)) is not None
            ),
        )

    def units(self, adapter: Adapter) -> tuple[str, str]:
        """Return the units of both ports; none if the adapter states no unit."""
        stated = self.entry.units
        if not stated:
            return "", ""
        copies = dict(adapter.copies)
        paths = {name: tuple(name.split(".")) for name in stated}
        received = {copies[path]: stated[name][0] for name, path in paths.items()}
        sent = {path: stated[name][1] for name, path in paths.items()}
        return (
            self._units(self._struct(self.entry.source), received),
            self._units(self._struct(self.entry.target), sent),
        )

    def _units(self, struct: Struct, stated: Mapping[tuple[str, ...], str]) -> str:
        """Return each unit of a struct's real numbers once: stated ones, else the defined."""
        every = (
            stated.get(leaf.path, leaf.unit)
            for leaf in leaves(self.model, struct)
            if leaf.path in stated or is_real(self.model, leaf.type)
        )
        return ", ".join(dict.fromkeys(unit for unit in every if unit))

    def _split(
        self,
        copies: dict[tuple[str, ...], tuple[str, ...]],
        target: Struct,
        path: tuple[str, ...],
    ) -> None:
        """Copy a struct member by member, if one of its members is converted."""
        self._type(target, path)
        prefix = next((k for k in copies if path[: len(k)] == k), None)
        if prefix is None:
            raise self._error(ADAPTER_VALUE, f"nothing fills {'.'.join(path)!r}")
        while prefix != path:
            from_, type_ = copies.pop(prefix), self._type(target, prefix)
            struct = self.model.declared(type_)
            assert isinstance(struct, Struct)
            for member in self.model.members(struct):
                copies[*prefix, member.name] = (*from_, member.name)
            prefix = path[: len(prefix) + 1]

    def _conversion(
        self,
        source: Struct,
        target: Struct,
        pair: Pair,
        to_ros: bool,
        constants: tuple[tuple[tuple[str, ...], AdapterConstant], ...],
    ) -> Adapter:
        """Return the adapter between a type of RT-Middleware and one of ROS 2."""
        rtm, ros = (source, target) if to_ros else (target, source)
        for struct, units in ((rtm, pair.rtm_units), (ros, pair.ros_units)):
            for path, unit in units.items():
                names = tuple(path.split("."))
                self._type(struct, names)
                own = self._unit(struct, names)
                if unit and own and not _is_equal(own, unit):
                    message = f"{path!r} of {struct.scoped} is in {own}, not in {unit}"
                    raise self._error(ADAPTER_UNIT, message)
        return Adapter(
            name=self.entry.name,
            source=source.name,
            target=target.name,
            copies=(),
            span=self.entry.span,
            conversion=pair.write if to_ros else pair.read,
            stamps=not to_ros and not pair.stamped,
            constants=constants,
        )

    def _constant(
        self, target: Struct, path: str, value: AdapterConstant
    ) -> tuple[tuple[str, ...], AdapterConstant]:
        """Return a member and its value, checked."""
        names = tuple(path.split("."))
        type_ = self._type(target, names)
        if not takes(shape_of(self.model, type_), value):
            message = f"{path!r} is {type_}, which is not {shown(value)}"
            raise self._error(ADAPTER_VALUE, message)
        return names, value

    def _scale(
        self,
        target: Struct,
        to: tuple[str, ...],
        source: Struct,
        from_: tuple[str, ...],
    ) -> tuple[float, float] | None:
        """Return factor and offset of a member; None if the value is copied. Raises InputError."""
        name = ".".join(to)
        own, theirs = self._unit(target, to), self._unit(source, from_)
        stated = self.entry.units.get(name)
        for known, said in (
            (theirs, stated and stated[0]),
            (own, stated and stated[1]),
        ):
            if known and said and _conversion_between(known, said) is None:
                message = f"`units` says {said} for {name!r}, its definition {known}"
                raise self._error(ADAPTER_UNIT, message)
        if stated is not None:
            theirs, own = stated
        if own is None or theirs is None or own == theirs:
            return None
        conversion = _conversion_between(theirs, own)
        if conversion is None:
            message = f"{name!r} is in {own}, {'.'.join(from_)!r} in {theirs}"
            raise self._error(ADAPTER_UNIT, message)
        if conversion == (1.0, 0.0):
            return None
        if not is_real(self.model, self._type(target, to)):
            message = f"{name!r} is {self._type(target, to)}, not float or double"
            hint = f"numbers in {theirs} are converted to {own} as real numbers"
            raise self._error(ADAPTER_VALUE, message, hint)
        return conversion

    def _unit(self, struct: Struct, path: tuple[str, ...]) -> str | None:
        """Return a member's unit: that of `@unit`, or the only one in its comment."""
        *outer, name = path
        if outer:
            inner = self.model.declared(self._type(struct, tuple(outer)))
            assert isinstance(inner, Struct)
            struct = inner
        return unit_of(next(m for m in self.model.members(struct) if m.name == name))

    def _struct(self, scoped: str) -> Struct:
        name = tuple(scoped.removeprefix("::").split("::"))
        structs = {d.name: d for d in self.model.declarations if isinstance(d, Struct)}
        if name in structs:
            return structs[name]
        structs_known = ["::".join(structs_known) for structs_known in structs]
        from difflib import get_close_matches

        close = get_close_matches(scoped, structs_known, n=1)
        ending = [k for k in structs_known if k.endswith(f"::{scoped}")]
        meant = next(iter(ending or close), None)
        hint = _include(name) or (f"did you mean {meant!r}?" if meant else None)
        raise self._error(ADAPTER_TYPE, f"no struct {scoped!r}", hint)

    def _kind(self, member: Member) -> tuple[Type, bool]:
        return self.model.unalias(member.type), member.optional

    def _type(self, struct: Struct, path: tuple[str, ...]) -> Type:
        """Return the type at the end of a path of member names."""
        members = {member.name: member for member in self.model.members(struct)}
        name, *rest = path
        if name not in members:
            from difflib import get_close_matches

            close = get_close_matches(name, members, n=1)
            choices = f"did you mean {close[0]!r}?" if close else ", ".join(members)
            message = f"{struct.scoped} has no member {name!r}"
            raise self._error(ADAPTER_MEMBER, message, choices)
        type_ = self.model.unalias(members[name].type)
        if members[name].optional:
            raise self._error(ADAPTER_VALUE, f"{name!r} is optional")
        if not rest:
            return type_
        inner = self.model.declared(type_)
        if not isinstance(inner, Struct):
            message = f"{name!r} of {struct.scoped} is not a struct"
            raise self._error(ADAPTER_MEMBER, message)
        return self._type(inner, tuple(rest))

    def _check(self, to: Type, from_: Type, name: str) -> None:
        if to != from_ and not _holds(to, from_):
            message = f"{name!r} is {to}, which is not always filled by {from_}"
            raise self._error(ADAPTER_VALUE, message)

    def _error(self, rule: Rule, message: str, hint: str | None = None) -> InputError:
        if rule is not ADAPTER_NAME:
            message = f"adapter {self.entry.name!r}: {message}"
        return InputError([rule.at(self.entry.span, message, hint=hint)])


def _is_equal(first: str, second: str) -> bool:
    """Return whether two texts denote one unit."""
    return first == second or _conversion_between(first, second) == (1.0, 0.0)


def _conversion_between(source: str, target: str) -> tuple[float, float] | None:
    """Return factor and offset between two units; None if they are incompatible or unreadable."""
    from rtgen.compiler.kit.units import (
        Relation,
        UnitError,
        conversion,
        parse,
        relation,
    )

    try:
        units = parse(source), parse(target)
    except UnitError:
        return None
    match relation(*units):
        case Relation.EQUAL:
            return 1.0, 0.0
        case Relation.SCALED:
            return conversion(*units)
    return None


def _include(name: tuple[str, ...]) -> str | None:
    """Return a hint for a struct that ships with rtgen, but is not included by a definition."""
    message = "/".join(name)
    if f"{message}.msg" in ros_interfaces():
        return f'#include "{message}.idl" in a definition'
    if name[:1] == ("RTC",):
        declared = re.compile(rf"\bstruct {re.escape(name[-1])}\b")
        for file in OPENRTM_IDL:
            if declared.search(idl_source(file)):
                return f'#include "{file}" in a definition'
    return None


def _holds(to: Type, from_: Type) -> bool:
    """Return whether one type represents every number of the other."""
    if not (isinstance(to, PrimitiveType) and isinstance(from_, PrimitiveType)):
        return False
    if to.kind is Primitive.DOUBLE and from_.kind is Primitive.FLOAT:
        return True
    if from_.kind not in INTEGER_RANGES or to.kind not in _EXACT_INTEGERS:
        return False
    low, high = INTEGER_RANGES[from_.kind]
    least, greatest = _EXACT_INTEGERS[to.kind]
    return least <= low and high <= greatest
