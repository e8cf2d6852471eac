"""Parser callbacks: build the node of the syntax tree for each grammar rule."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.frontends.idl.syntax.expression_builder import (
    Children,
    ExpressionBuilder,
    end_of,
    name_of,
    start_of,
)
from rtgen.compiler.model import Direction, Primitive

if TYPE_CHECKING:
    from rtgen.compiler.frontends.kit.lalr import Token


_PRIMITIVES = {kind.value: kind for kind in Primitive}
_DIRECTIONS = {direction.value: direction for direction in Direction}


def _take(children: Children, *kinds: str) -> Token | None:
    """Remove and return the first child if it is a token of these kinds."""
    if children and getattr(children[0], "type", None) in kinds:
        token: Token = children.pop(0)
        return token
    return None


def _pop(children: Children, kind: type) -> Any:
    """Remove and return the first child of this type, if there is one."""
    for index, child in enumerate(children):
        if type(child) is kind:
            return children.pop(index)
    return None


class _Bases(tuple[tree.ScopedName, ...]):
    __slots__ = ()


class _Supports(tuple[tree.ScopedName, ...]):
    __slots__ = ()


class _Truncatable(_Bases):
    __slots__ = ()


class Builder(ExpressionBuilder):
    """One method for each rule or alias of `idl.lark`; `children` as passed by lark."""

    # Lists of declarations

    def specification(self, children: Children) -> tuple[tree.Item, ...]:
        return tuple(children)

    def item(self, children: Children) -> tree.Item:
        *annotations, node, end = children
        if type(node) is tree.Item:
            annotations += node.annotations
            node = node.node
        return tree.Item(tuple(annotations), node, annotations[0].start, end_of(end))

    def plain_item(self, children: Children) -> tree.Item:
        node, end = children
        if type(node) is tree.Item:
            return tree.Item(node.annotations, node.node, node.start, end_of(end))
        return tree.Item((), node, node.start, end_of(end))

    def extra_semicolon(self, children: Children) -> tree.Item:
        start = start_of(children[0])
        return tree.Item((), tree.Skipped(start), start, start + 1)

    def skipped(self, children: Children) -> tree.Item:
        start = start_of(children[0])
        return tree.Item((), tree.Skipped(start), start, start)

    def body(self, children: Children) -> tree.Body:
        opening, *items, closing = children
        return tree.Body(tuple(items), end_of(opening), start_of(closing))

    # Modules

    def module(self, children: Children) -> tree.Module:
        keyword, name, body = children
        return tree.Module(name_of(name), body, start_of(keyword))

    def template_module(self, children: Children) -> tree.Module:
        return tree.Module(
            name_of(children[1]), children[-1], start_of(children[0]), template=True
        )

    def formal(self, children: Children) -> tree.Name:
        return name_of(children[-1])

    def template_instance(self, children: Children) -> tree.Unused:
        return self._unused(children, children[-1], "template module")

    def module_alias(self, children: Children) -> tree.Unused:
        keyword, target, name = children
        return tree.Unused(
            "alias", name_of(name), start_of(keyword), end_of(name), target
        )

    def _unused(self, children: Children, name: Token, keyword: str) -> tree.Unused:
        last = children[-1]
        end = last.end if hasattr(last, "end") else end_of(last)
        return tree.Unused(keyword, name_of(name), start_of(children[0]), end)

    # Constants

    def const_dcl(self, children: Children) -> tree.Const:
        keyword, type_, name, _, value = children
        return tree.Const(type_, name_of(name), value, start_of(keyword))

    def annotated_type(self, children: Children) -> tree.TypeNode:
        type_: tree.TypeNode = children[-1]
        return type_

    # Types

    def basic_type(self, children: Children) -> tree.BasicType:
        kind = _PRIMITIVES[" ".join(children)]
        return tree.BasicType(kind, start_of(children[0]), end_of(children[-1]))

    def text_type(self, children: Children) -> tree.TextType:
        token, *bound = children
        return tree.TextType(
            token.type == "WTEXT",
            bound[1] if bound else None,
            start_of(token),
            end_of(children[-1]),
        )

    def sequence_type(self, children: Children) -> tree.Sequence:
        keyword, _, element, *bound, closing = children
        return tree.Sequence(
            element, bound[0] if bound else None, start_of(keyword), end_of(closing)
        )

    def fixed_type(self, children: Children) -> tree.Fixed:
        if len(children) == 1:
            return tree.Fixed(None, None, start_of(children[0]), end_of(children[0]))
        keyword, _, digits, scale, closing = children
        return tree.Fixed(digits, scale, start_of(keyword), end_of(closing))

    def map_type(self, children: Children) -> tree.Map:
        keyword, _, key, value, *bound, closing = children
        return tree.Map(
            key, value, bound[0] if bound else None, start_of(keyword), end_of(closing)
        )

    def typedef_dcl(self, children: Children) -> tree.Typedef:
        return tree.Typedef(children[-2], children[-1], start_of(children[0]))

    def declarators(self, children: Children) -> tuple[tree.Declarator, ...]:
        return tuple(children)

    def declarator(self, children: Children) -> tree.Declarator:
        name = name_of(children[0])
        if len(children) == 1:
            return tree.Declarator(name, (), name.start, name.end)
        dimensions = tuple(children[1:])
        return tree.Declarator(name, dimensions, name.start, dimensions[-1].end + 1)

    def dimension(self, children: Children) -> tree.Expression:
        value: tree.Expression = children[0]
        return value

    def native_dcl(self, children: Children) -> tree.Native:
        return tree.Native(name_of(children[1]), start_of(children[0]))

    def struct_dcl(self, children: Children) -> tree.Struct:
        base = children[3] if len(children) == 5 else None
        return tree.Struct(
            name_of(children[1]), base, children[-1], start_of(children[0])
        )

    def exception_dcl(self, children: Children) -> tree.Struct:
        keyword, name, body = children
        return tree.Struct(name_of(name), None, body, start_of(keyword), exception=True)

    def struct_forward(self, children: Children) -> tree.Forward:
        return tree.Forward("struct", name_of(children[1]), "", start_of(children[0]))

    def union_forward(self, children: Children) -> tree.Forward:
        return tree.Forward("union", name_of(children[1]), "", start_of(children[0]))

    def member(self, children: Children) -> tree.Member:
        type_, declarators = children
        return tree.Member(type_, declarators, type_.start)

    def annotated_member(self, children: Children) -> tree.Item:
        type_, *annotations, declarators = children
        member = tree.Member(type_, declarators, type_.start)
        return tree.Item(tuple(annotations), member, type_.start, declarators[-1].end)

    def union_dcl(self, children: Children) -> tree.Union:
        keyword, name, _, _, switch, _, body = children
        return tree.Union(name_of(name), switch, body, start_of(keyword))

    def case(self, children: Children) -> tree.Case:
        *labels, type_, declarator = children
        return tree.Case(tuple(labels), type_, declarator, labels[0].start)

    def annotated_case(self, children: Children) -> tree.Item:
        labels = tuple(c for c in children if isinstance(c, tree.Label))
        annotations = tuple(c for c in children if isinstance(c, tree.Annotation))
        case = tree.Case(labels, children[-2], children[-1], labels[0].start)
        return tree.Item(annotations, case, case.start, case.declarator.end)

    def label(self, children: Children) -> tree.Label:
        value = children[1] if len(children) == 3 else None
        return tree.Label(value, start_of(children[0]), end_of(children[-1]))

    def enumerator(self, children: Children) -> tree.Enumerator:
        annotations = tuple(c for c in children if isinstance(c, tree.Annotation))
        rest = children[len(annotations) :]
        name = name_of(rest[0])
        value = rest[2] if len(rest) == 3 else None
        start = annotations[0].start if annotations else name.start
        return tree.Enumerator(
            annotations, name, value, start, value.end if value else name.end
        )

    def enumerators(
        self, children: Children
    ) -> tuple[tuple[tree.Enumerator, ...], int | None]:
        if children and not isinstance(children[-1], tree.Enumerator):
            return tuple(children[:-1]), start_of(children[-1])
        return tuple(children), None

    def _enumeration(self, children: Children, mask: bool) -> tree.Enum:
        keyword, name, _, (members, trailing), closing = children
        return tree.Enum(
            name_of(name), members, trailing, start_of(keyword), end_of(closing), mask
        )

    def enum_dcl(self, children: Children) -> tree.Enum:
        return self._enumeration(children, mask=False)

    def bitmask_dcl(self, children: Children) -> tree.Enum:
        return self._enumeration(children, mask=True)

    def bitset_dcl(self, children: Children) -> tree.Bitset:
        base = children[3] if len(children) == 5 else None
        return tree.Bitset(
            name_of(children[1]), base, children[-1], start_of(children[0])
        )

    def bitfield(self, children: Children) -> tree.Bitfield:
        keyword, _, bits, *rest = children
        names = tuple(name_of(c) for c in rest if getattr(c, "type", "") == "IDENT")
        type_ = rest[0] if getattr(rest[0], "type", "") != "GREATER" else None
        return tree.Bitfield(bits, type_, names, start_of(keyword))

    # Interfaces

    def inherits(self, children: Children) -> _Bases:
        kind = _Bases
        children = children[1:]
        if _take(children, "TRUNCATABLE"):
            kind = _Truncatable
        return kind(children)

    def supports(self, children: Children) -> _Supports:
        return _Supports(children)

    def interface_dcl(self, children: Children) -> tree.Interface:
        start = start_of(children[0])
        modifier = _take(children, "ABSTRACT", "LOCAL")
        bases = _pop(children, _Bases) or _pop(children, _Truncatable) or ()
        _, name, body = children
        return tree.Interface(
            name_of(name), tuple(bases), body, str(modifier or ""), start
        )

    def interface_forward(self, children: Children) -> tree.Forward:
        start = start_of(children[0])
        modifier = _take(children, "ABSTRACT", "LOCAL")
        return tree.Forward(
            "interface", name_of(children[1]), str(modifier or ""), start
        )

    def operation(self, children: Children) -> tree.Operation:
        start = start_of(children[0])
        oneway = _take(children, "ONEWAY")
        type_, name, (parameters, end), *rest = children
        raises = _pop(rest, tree.Names)
        context = rest[0] if rest else ()
        end = context[-1].end + 1 if context else raises.end if raises else end
        return tree.Operation(
            name_of(name), type_, parameters, raises, context, bool(oneway), start, end
        )

    def parameters(self, children: Children) -> tuple[tuple[tree.Parameter, ...], int]:
        return tuple(children[1:-1]), end_of(children[-1])

    def parameter(self, children: Children) -> tree.Parameter:
        *before, type_, declarator = children
        if len(before) == 1 and (direction := _DIRECTIONS.get(before[0])):
            start = before[0].start_pos
            return tree.Parameter(
                (), direction, type_, declarator, start, declarator.end
            )
        annotations = tuple(c for c in before if type(c) is tree.Annotation)
        directions = [_DIRECTIONS[c] for c in before if c not in annotations]
        return tree.Parameter(
            annotations,
            directions[0] if directions else None,
            type_,
            declarator,
            start_of(children[0]),
            declarator.end,
        )

    def raises(self, children: Children) -> tree.Names:
        keyword, _, *names, closing = children
        return tree.Names(
            str(keyword), tuple(names), start_of(keyword), end_of(closing)
        )

    def context(self, children: Children) -> tuple[tree.Text, ...]:
        return tuple(children[1:-1])

    def attribute(self, children: Children) -> tree.Attribute:
        start = start_of(children[0])
        readonly = _take(children, "READONLY")
        get_raises, set_raises = children.pop()
        rest = [c for c in children[1:] if not isinstance(c, tree.Annotation)]
        names = tuple(map(name_of, rest[1:]))
        return tree.Attribute(
            rest[0], names, bool(readonly), get_raises, set_raises, start
        )

    def set_raises(self, children: Children) -> tuple[tree.Names]:
        return (self.raises(children),)

    def accessors(
        self, children: Children
    ) -> tuple[tree.Names | None, tree.Names | None]:
        setter = _pop(children, tuple)
        return children[0] if children else None, setter[0] if setter else None

    # Valuetypes

    def value_dcl(self, children: Children) -> tree.Valuetype:
        start = start_of(children[0])
        modifier = _take(children, "ABSTRACT", "CUSTOM")
        supports = _pop(children, _Supports) or ()
        truncatable = _pop(children, _Truncatable)
        bases = truncatable or _pop(children, _Bases) or ()
        keyword, name, body = children
        return tree.Valuetype(
            str(keyword),
            name_of(name),
            tuple(bases),
            truncatable is not None,
            tuple(supports),
            body,
            str(modifier or ""),
            start,
        )

    def value_forward(self, children: Children) -> tree.Forward:
        start = start_of(children[0])
        modifier = _take(children, "ABSTRACT", "CUSTOM")
        keyword, name = children
        return tree.Forward(str(keyword), name_of(name), str(modifier or ""), start)

    def value_box(self, children: Children) -> tree.ValueBox:
        keyword, name, type_ = children
        return tree.ValueBox(name_of(name), type_, start_of(keyword))

    def state(self, children: Children) -> tree.State:
        keyword, *_, member = children
        if type(member) is tree.Item:
            member = member.node
        return tree.State(keyword.type == "PUBLIC", member, start_of(keyword))

    def factory(self, children: Children) -> tree.Operation:
        keyword, name, (parameters, end), *rest = children
        raises = rest[0] if rest else None
        return tree.Operation(
            name_of(name),
            None,
            parameters,
            raises,
            (),
            False,
            start_of(keyword),
            raises.end if raises else end,
            factory=str(keyword),
        )

    # Components

    def component_dcl(self, children: Children) -> tree.Component:
        supports = _pop(children, _Supports) or ()
        bases = _pop(children, _Bases) or _pop(children, _Truncatable) or (None,)
        keyword, name, body = children
        return tree.Component(
            name_of(name), bases[0], tuple(supports), body, start_of(keyword)
        )

    def component_forward(self, children: Children) -> tree.Forward:
        return tree.Forward(
            "component", name_of(children[1]), "", start_of(children[0])
        )

    def port(self, children: Children) -> tree.PortItem:
        *_, type_, name = children
        keyword = " ".join(str(c) for c in children[:-2])
        return tree.PortItem(
            keyword, type_, name_of(name), start_of(children[0]), end_of(name)
        )

    def primary_key(self, children: Children) -> tuple[tree.ScopedName]:
        return (children[0],)

    def home_dcl(self, children: Children) -> tree.Home:
        supports = _pop(children, _Supports) or ()
        bases = _pop(children, _Bases) or _pop(children, _Truncatable) or (None,)
        key = _pop(children, tuple)
        keyword, name, manages, body = children
        return tree.Home(
            name_of(name),
            bases[0],
            tuple(supports),
            manages,
            key[0] if key else None,
            body,
            start_of(keyword),
        )

    def porttype_dcl(self, children: Children) -> tree.Unused:
        return self._unused(children, children[1], "porttype")

    def connector_dcl(self, children: Children) -> tree.Unused:
        return self._unused(children, children[1], "connector")

    # CORBA 3 statements

    def identity(self, children: Children) -> tree.Identity:
        keyword, name, text = children
        return tree.Identity(str(keyword), name, text, start_of(keyword))

    def import_dcl(self, children: Children) -> tree.Import:
        keyword, name = children
        scoped = name if isinstance(name, tree.ScopedName) else None
        return tree.Import(scoped, start_of(keyword))
