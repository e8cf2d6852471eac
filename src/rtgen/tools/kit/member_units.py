"""The units of the numbers in samples, from the comments in the modules of their types."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterator, Mapping
from functools import cache, lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, Final, TypeAlias

from rtgen.compiler.typemap.member_units import unit_in
from rtgen.facts.files import read_file
from rtgen.runtime import ComponentProfile, InPort, OutPort
from rtgen.runtime.marshalling.descriptors import (
    ArrayDescriptor,
    Descriptor,
    MapDescriptor,
    PrimitiveDescriptor,
    SequenceDescriptor,
    StructDescriptor,
    UnionDescriptor,
    ValueDescriptor,
    plain,
)

MemberPath: TypeAlias = tuple[str, ...]
"""The names of a member and of those around it, as in the definition, without indices."""

_TIME: Final = "tm"
_REALS: Final = ("float", "double", "long double")
_INTEGERS: Final = ("short", "long", "octet", "int8", "uint8")
_MAX_LEAVES: Final = 1000
_MAX_TYPES: Final = 1000


Units: TypeAlias = Callable[[MemberPath], str]
"""Returns the unit of a member; empty without one."""


def no_units(path: MemberPath) -> str:
    """Return no unit."""
    return ""


def units_of(
    profile: ComponentProfile, port: InPort[Any] | OutPort[Any]
) -> MemberUnits:
    """Return the units of the members of a data port of a component."""
    stated = {each.name: each.unit for each in profile.ports if not each.port}
    type_: Any = port.type
    return of_type(type_, stated.get(port.name, ""))


@lru_cache(_MAX_TYPES)
def of_type(type_: Any, stated: str = "") -> MemberUnits:
    """Return the units of the members of a type, with the unit that a port states."""
    return MemberUnits(type_, stated)


class MemberUnits:
    """The units of the members of a port's type.

    `stated` is the port's own unit, or its list of units for each kind of member. It decides for a
    member of the same dimension, and for members without a unit: one unit for all real numbers,
    several for as many members in their order.
    """

    def __init__(self, type_: Any, stated: str = "") -> None:
        leaves = dict(islice(_leaves(type_._descriptor_, (), ()), _MAX_LEAVES))
        if len(leaves) > 1:
            leaves = {
                path: leaf for path, leaf in leaves.items() if path[:1] != (_TIME,)
            }
        has_reals = any(is_real for is_real, _ in leaves.values())
        texts = [text.strip() for text in stated.split(",") if text.strip()]
        in_order = texts if len(texts) == len(leaves) else [""] * len(leaves)
        self.units: dict[MemberPath, str] = {}
        """The units by paths; members without a unit are left out."""
        for (path, (is_real, own)), placed in zip(
            leaves.items(), in_order, strict=True
        ):
            unit = _of_dimension(own, texts) if own else placed
            if not own and len(texts) == 1 and (is_real or not has_reals):
                unit = texts[0]
            if unit:
                self.units[path] = unit

    def __call__(self, path: MemberPath) -> str:
        """Return the unit of a member; empty without one."""
        return self.units.get(path, "")


def _of_dimension(own: str, stated: list[str]) -> str:
    """Return the stated unit that has the dimension of a member's own; else its own."""
    if own in stated or not stated:
        return own
    from rtgen.compiler.kit.units import Relation, UnitError, parse, relation

    near = []
    for text in stated:
        try:
            related = relation(parse(own), parse(text))
        except UnitError:
            continue
        near += [text] * (related in (Relation.EQUAL, Relation.SCALED))
    return near[0] if len(near) == 1 else own


def _leaves(
    descriptor: Descriptor, path: MemberPath, around: tuple[object, ...], unit: str = ""
) -> Iterator[tuple[MemberPath, tuple[bool, str]]]:
    """Yield the numbers in a type: the path, whether it is a real number, and its unit."""
    target = plain(descriptor)
    if any(target is each for each in around):
        return
    around = (*around, target)
    match target:
        case PrimitiveDescriptor(name):
            is_real = name in _REALS
            if is_real or name.removeprefix("unsigned ").split()[0] in _INTEGERS:
                yield path, (is_real, unit)
        case SequenceDescriptor(element=element) | ArrayDescriptor(element=element):
            yield from _leaves(element, path, around, unit)
        case MapDescriptor(value=value):
            yield from _leaves(value, path, around, unit)
        case StructDescriptor(members=members):
            yield from _of_members(target, members, path, around)
        case ValueDescriptor():
            yield from _of_members(target, target.all_members(), path, around)
        case UnionDescriptor(branches=branches):
            texts = _comments(target.class_)
            units = {
                unit_in(texts.get(each.attribute or each.name, "")) for each in branches
            }
            [common] = units if len(units) == 1 else [None]
            for branch in branches:
                yield from _leaves(branch.type, (*path, "value"), around, common or "")


def _of_members(
    target: Any, members: Any, path: MemberPath, around: tuple[object, ...]
) -> Iterator[tuple[MemberPath, tuple[bool, str]]]:
    texts = _comments(target.class_)
    for member in members:
        unit = unit_in(texts.get(member.attribute, "")) or ""
        yield from _leaves(member.type, (*path, member.name), around, unit)


def _comments(class_: Any) -> Mapping[str, str]:
    """Return the comments of a class's attributes, with those of its bases."""
    comments: dict[str, str] = {}
    for base in reversed(getattr(class_, "__mro__", ())):
        try:
            file = inspect.getsourcefile(base)
        except TypeError:
            continue
        if file is not None and "_descriptor_" in vars(base):
            comments |= _in_module(file, _changed(file)).get(base.__name__, {})
    return comments


def _changed(file: str) -> int:
    """Return when a file was changed [ns]; 0 for one that is not there."""
    try:
        return Path(file).stat().st_mtime_ns
    except OSError:
        return 0


@cache
def _in_module(file: str, changed: int) -> Mapping[str, Mapping[str, str]]:
    """Return the comments of the attributes of a module's classes; none if it cannot be read."""
    try:
        tree = ast.parse(read_file(Path(file)))
    except (OSError, SyntaxError, ValueError):
        return {}
    return {
        each.name: dict(_attributes(each))
        for each in ast.walk(tree)
        if isinstance(each, ast.ClassDef)
    }


def _attributes(class_: ast.ClassDef) -> Iterator[tuple[str, str]]:
    before: ast.stmt | None = None
    for statement in class_.body:
        match before, statement:
            case (
                ast.AnnAssign(target=ast.Name(id=name)),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                yield name, text
            case _, ast.FunctionDef(name=name):
                yield name, ast.get_docstring(statement) or ""
        before = statement
