"""Parser callbacks: builds the node of the syntax tree for each grammar rule."""

from __future__ import annotations

from typing import Any

from rtgen.compiler.frontends.cdl.syntax import statements, tree
from rtgen.compiler.frontends.cdl.syntax.expression_builder import (
    Children,
    ExpressionBuilder,
    end_of,
    first_in,
    is_token,
    keyword_of,
    name_of,
    nodes_in,
    start_of,
    tokens_in,
    word_of,
)
from rtgen.compiler.frontends.cdl.syntax.keywords import TERMINALS
from rtgen.facts.tdr import Scalar

_SCALARS = {kind.value: kind for kind in Scalar} | {"char": Scalar.CHAR}


class Head:
    """`namespace name`, before its opening brace."""

    __slots__ = ("end", "name", "start")

    def __init__(self, name: tree.Name, start: int) -> None:
        self.name = name
        self.start = start
        self.end = name.end


class Builder(ExpressionBuilder):
    """One method for each rule or alias of `cdl.lark`; `children` as passed by lark."""

    # Lists

    def specification(self, children: Children) -> tuple[statements.Item, ...]:
        return tuple(children)

    def item(self, children: Children) -> statements.Item:
        specifiers, node, end = children
        return statements.Item(specifiers.start, end.end_pos, specifiers, node)

    def plain_item(self, children: Children) -> statements.Item:
        node, end = children
        return statements.Item(node.start, end.end_pos, None, node)

    def unended_item(self, children: Children) -> statements.Item:
        (node,) = children
        return statements.Item(node.start, node.end, None, node)

    def skipped(self, children: Children) -> statements.Item:
        start = children[0].start_pos
        return statements.Item(start, start, None, statements.Skipped(start, start))

    # Files and name spaces

    def namespace_head(self, children: Children) -> Head:
        keyword, name = children
        return Head(name_of(name), keyword.start_pos)

    def namespace_dcl(self, children: Children) -> statements.Namespace:
        head, _, *items, end = children
        return statements.Namespace(head.start, end.end_pos, head.name, tuple(items))

    def import_dcl(self, children: Children) -> statements.Import:
        keyword, _, path, end = children
        return statements.Import(
            keyword.start_pos, end.end_pos, path[1:-1], path.type == "ANGLE"
        )

    def import_c_dcl(self, children: Children) -> statements.ImportC:
        header, *definitions = nodes_in(children, tree.Text)
        return statements.ImportC(
            start_of(children[0]),
            end_of(children[-1]),
            header,
            definitions[0] if definitions else None,
        )

    def generate_dcl(self, children: Children) -> statements.Generate:
        keyword, _, plugin, target, argument, end = children
        return statements.Generate(
            keyword.start_pos, end.end_pos, name_of(plugin), target, argument
        )

    # Types

    def typedef_dcl(self, children: Children) -> tree.Typedef:
        keyword, *specifiers, type_, declarators = children
        return tree.Typedef(
            keyword.start_pos,
            declarators[-1].end,
            specifiers[0] if specifiers else None,
            type_,
            declarators,
        )

    def type_dcl(self, children: Children) -> tree.TypeStatement:
        (type_,) = children
        return tree.TypeStatement(type_.start, type_.end, type_)

    def const_dcl(self, children: Children) -> Any:
        return children[0]

    def declaration(self, children: Children) -> tree.Declaration:
        type_, declarators = children
        return tree.Declaration(type_.start, declarators[-1].end, type_, declarators)

    def init_declarators(self, children: Children) -> tuple[Any, ...]:
        return tuple(children)

    def declarators(self, children: Children) -> tuple[Any, ...]:
        return tuple(children)

    def init_declarator(self, children: Children) -> tree.InitDeclarator:
        declarator, *rest = children
        value = rest[1] if rest else None
        end = value.end if value is not None else declarator.end
        return tree.InitDeclarator(declarator.start, end, declarator, value)

    def qualified_type(self, children: Children) -> tree.QualifiedType:
        type_ = children[-1]
        qualifiers = tuple(children[:-1])
        return tree.QualifiedType(children[0].start, type_.end, qualifiers, type_)

    def qualifier(self, children: Children) -> tree.Name:
        return keyword_of(children[0])

    def basic_type(self, children: Children) -> tree.BasicType:
        *sign, word = children
        kind = _SCALARS[word_of(word)]
        return tree.BasicType(
            start_of(children[0]),
            word.end_pos,
            kind,
            kind is Scalar.CHAR and word.type == "CHAR",
            word_of(sign[0]) if sign else None,
        )

    def typedef_name(self, children: Children) -> tree.TypedefName:
        name = name_of(children[0])
        return tree.TypedefName(name.start, name.end, name)

    def descriptor(self, children: Children) -> tree.DescriptorOf:
        keyword, _, signature, end = children
        return tree.DescriptorOf(keyword.start_pos, end.end_pos, signature)

    def struct_type(self, children: Children) -> tree.StructSpecifier:
        tag = tokens_in(children, "IDENT")
        members = (
            nodes_in(children, tree.MemberItem)
            if tokens_in(children, "LBRACE")
            else None
        )
        return tree.StructSpecifier(
            start_of(children[0]),
            end_of(children[-1]),
            name_of(tag[0]) if tag else None,
            members,
        )

    def member(self, children: Children) -> tree.MemberItem:
        *specifiers, type_, declarators, end = children
        first = specifiers[0] if specifiers else type_
        return tree.MemberItem(
            first.start,
            end.end_pos,
            specifiers[0] if specifiers else None,
            type_,
            declarators,
        )

    def enum_keyword(self, children: Children) -> tree.Name:
        return keyword_of(children[0])

    def enum_type(self, children: Children) -> tree.EnumSpecifier:
        keyword = children[0]
        tag = tokens_in(children, "IDENT")
        enumerators = (
            nodes_in(children, tree.Enumerator)
            if tokens_in(children, "LBRACE")
            else None
        )
        return tree.EnumSpecifier(
            keyword.start,
            end_of(children[-1]),
            keyword.text,
            name_of(tag[0]) if tag else None,
            enumerators,
        )

    def enumerator(self, children: Children) -> tree.Enumerator:
        return tree.Enumerator(
            name_of(children[0]), children[2] if len(children) > 1 else None
        )

    # Declarators

    def declarator(self, children: Children) -> tree.Declarator:
        *pointers, direct = children
        if not pointers:
            whole: tree.Declarator = direct
            return whole
        return tree.Declarator(
            pointers[0].start,
            direct.end,
            tuple(pointers),
            direct.inner,
            direct.suffixes,
        )

    def direct_declarator(self, children: Children) -> tree.Declarator:
        first = children[0]
        inner = first if isinstance(first, tree.Declarator) else name_of(first)
        suffixes = tuple(children[1:])
        end = suffixes[-1].end if suffixes else inner.end
        return tree.Declarator(inner.start, end, (), inner, suffixes)

    def group_declarator(self, children: Children) -> tree.Declarator:
        opening, inner, closing = children
        return tree.Declarator(opening.start_pos, closing.end_pos, (), inner, ())

    def array_suffix(self, children: Children) -> tree.ArraySuffix:
        opening, *size, closing = children
        return tree.ArraySuffix(
            opening.start_pos, closing.end_pos, size[0] if size else None
        )

    def pointer(self, children: Children) -> tree.Pointer:
        star, *qualifier = children
        return tree.Pointer(
            star.start_pos, end_of(children[-1]), qualifier[0] if qualifier else None
        )

    def parameters(self, children: Children) -> tree.Parameters:
        opening, *items, closing = children
        return tree.Parameters(opening.start_pos, closing.end_pos, tuple(items))

    def parameter(self, children: Children) -> tree.Parameter:
        first, last = children[0], children[-1]
        specifiers = first if isinstance(first, tree.Specifiers) else None
        declarator = last if isinstance(last, tree.Declarator) else None
        type_ = first if specifiers is None else children[1]
        return tree.Parameter(first.start, last.end, specifiers, type_, declarator)

    def type_name(self, children: Children) -> tree.TypeName:
        type_, *declarator = children
        return tree.TypeName(
            type_.start, children[-1].end, type_, declarator[0] if declarator else None
        )

    def abstract_declarator(self, children: Children) -> tree.Declarator:
        pointers = nodes_in(children, tree.Pointer)
        direct = first_in(children, tree.Declarator)
        return tree.Declarator(
            children[0].start,
            children[-1].end,
            pointers,
            direct.inner if direct is not None else None,
            direct.suffixes if direct is not None else (),
        )

    def direct_abstract(self, children: Children) -> tree.Declarator:
        inner = first_in(children, tree.Declarator)
        suffixes = tuple(child for child in children if child is not inner)
        return tree.Declarator(children[0].start, children[-1].end, (), inner, suffixes)

    def group_abstract(self, children: Children) -> tree.Declarator:
        return self.group_declarator(children)

    # Specifiers

    def specifiers(self, children: Children) -> tree.Specifiers:
        opening, *items, closing = children
        terminals = tuple(item for item in items if item.word in TERMINALS)
        broken = len(terminals) < len(items)
        return tree.Specifiers(opening.start_pos, closing.end_pos, terminals, broken)

    def specifier(self, children: Children) -> tree.Specifier:
        word, *rest = children
        arguments = tuple(child for child in rest if not isinstance(child, str))
        return tree.Specifier(
            word.start_pos, end_of(children[-1]), str(word), arguments
        )

    def name(self, children: Children) -> tree.Name:
        return name_of(children[0])

    def plugin(self, children: Children) -> tree.Name:
        return tree.Name(start_of(children[0]), end_of(children[-1]), "".join(children))

    def allocation(self, children: Children) -> tree.Allocation:
        *path, operator, value = children
        names = tuple(name_of(token) for token in tokens_in(path, "IDENT"))
        return tree.Allocation(
            names[0].start,
            value.end,
            names,
            first_in(path, tree.Subscript),
            str(operator),
            value,
        )

    def restriction(self, children: Children) -> tree.Restriction:
        names = tuple(name_of(token) for token in tokens_in(children, "IDENT"))
        return tree.Restriction(
            names[0].start,
            end_of(children[-1]),
            names,
            nodes_in(children, tree.ScopedName),
        )

    # Signatures and celltypes

    def signature_dcl(self, children: Children) -> statements.Signature:
        return statements.Signature(*self._block(children))

    def celltype_dcl(self, children: Children) -> statements.Celltype:
        return statements.Celltype(*self._block(children))

    def composite_dcl(self, children: Children) -> statements.Composite:
        return statements.Composite(*self._block(children))

    def region_dcl(self, children: Children) -> statements.Region:
        return statements.Region(*self._block(children))

    def _block(
        self, children: Children
    ) -> tuple[int, int, tree.Name, tuple[statements.Item, ...]]:
        keyword, name, _, *items, end = children
        return keyword.start_pos, end.end_pos, name_of(name), tuple(items)

    def function(self, children: Children) -> statements.Function:
        type_, declarator = children
        return statements.Function(type_.start, declarator.end, type_, declarator)

    def port(self, children: Children) -> statements.Port:
        keyword, signature, name, *subscript = children
        return statements.Port(
            keyword.start_pos,
            end_of(children[-1]),
            word_of(keyword),
            signature,
            name_of(name),
            subscript[0] if subscript else None,
            None,
        )

    def joined_port(self, children: Children) -> statements.Port:
        keyword, signature, name, _, target = children
        return statements.Port(
            keyword.start_pos,
            target.end,
            word_of(keyword),
            signature,
            name_of(name),
            None,
            target,
        )

    def port_of(self, children: Children) -> statements.PortOf:
        owner, _, port = children
        return statements.PortOf(owner.start, port.end_pos, owner, name_of(port), None)

    def attributes(self, children: Children) -> statements.Attributes:
        keyword, _, *items, end = children
        return statements.Attributes(
            keyword.start_pos, end.end_pos, word_of(keyword), tuple(items)
        )

    def require(self, children: Children) -> statements.Require:
        keyword, target = children
        return statements.Require(keyword.start_pos, target.end, None, target)

    def named_require(self, children: Children) -> statements.Require:
        keyword, name, _, target = children
        return statements.Require(keyword.start_pos, target.end, name_of(name), target)

    def factory(self, children: Children) -> statements.Factory:
        keyword, _, *items, end = children
        return statements.Factory(
            keyword.start_pos, end.end_pos, word_of(keyword), tuple(items)
        )

    def factory_call(self, children: Children) -> statements.FactoryCall:
        function, _, file, format_, *arguments, end = children
        return statements.FactoryCall(
            function.start_pos,
            end.end_pos,
            name_of(function),
            file,
            format_,
            tuple(arguments),
        )

    # Cells and composites

    def cell_dcl(self, children: Children) -> statements.Cell:
        keyword, celltype, name, *body = children
        return statements.Cell(
            keyword.start_pos,
            end_of(children[-1]),
            celltype,
            name_of(name),
            tuple(body[1:-1]) if body else None,
        )

    def join(self, children: Children) -> statements.Join:
        name, *subscript, _, value = children
        return _join(name, subscript, value)

    def composite_join(self, children: Children) -> statements.Join:
        name, *subscript, _, keyword, _, outer = children
        value = tree.OfComposite(keyword.start_pos, outer.end_pos, name_of(outer))
        return _join(name, subscript, value)

    def reverse_join(self, children: Children) -> statements.ReverseJoin:
        name, *left, operator, owner, _, port = children[: _after_port(children)]
        right = children[_after_port(children) :]
        target = statements.PortOf(
            owner.start,
            end_of(children[-1]),
            owner,
            name_of(port),
            right[0] if right else None,
        )
        assert is_token(operator, "LESS_EQUAL")
        return statements.ReverseJoin(
            name.start_pos, target.end, name_of(name), left[0] if left else None, target
        )

    def export(self, children: Children) -> statements.Export:
        port, *_, name = children
        return statements.Export(
            port.start_pos, name.end_pos, name_of(port), name_of(name)
        )

    def entry_export(self, children: Children) -> statements.EntryExport:
        name, cell, port = tokens_in(children, "IDENT")
        return statements.EntryExport(
            start_of(children[0]),
            port.end_pos,
            name_of(name),
            name_of(cell),
            name_of(port),
        )

    # Statements of graphical editors

    def tool_info(self, children: Children) -> statements.ToolInformation:
        return statements.ToolInformation(
            start_of(children[0]), end_of(children[-1]), str(children[0])
        )

    def json_object(self, children: Children) -> statements.Skipped:
        return statements.Skipped(start_of(children[0]), end_of(children[-1]))

    json_property = json_array = location = port_location = bar = json_object


def _after_port(children: Children) -> int:
    """Return the position for the right subscript of a reverse join."""
    dot = next(i for i, child in enumerate(children) if is_token(child, "DOT"))
    return dot + 2


def _join(name: Any, subscript: Children, value: Any) -> statements.Join:
    index = subscript[0] if subscript else None
    return statements.Join(name.start_pos, value.end, name_of(name), index, value)
