"""Parser callbacks: builds the node of the syntax tree for each grammar rule."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from rtgen.facts.tdr import Scalar
from rtgen.frontends.cdl.syntax import tree
from rtgen.frontends.cdl.syntax.words import TERMINALS, WORDS

if TYPE_CHECKING:
    from rtgen.frontends.kit.lalr import Token

Children: TypeAlias = list[Any]

_SCALARS = {kind.value: kind for kind in Scalar} | {"char": Scalar.CHAR}
_NAMED = ("IDENT", "TYPE_NAME")


def _start(node: Any) -> int:
    """The start offset of a node or token."""
    start: int = node.start if hasattr(node, "start") else node.start_pos
    return start


def _end(node: Any) -> int:
    """The end offset of a node or token."""
    end: int = node.end if hasattr(node, "end") else node.end_pos
    return end


def _name(token: Token) -> tree.Name:
    return tree.Name(str(token), token.start_pos, token.end_pos)


def _word(token: Token) -> str:
    """The keyword of a token, also of one replaced by error recovery."""
    return WORDS[token.type]


def _keyword(token: Token) -> tree.Name:
    return tree.Name(_word(token), token.start_pos, token.end_pos)


def _nodes(children: Children, *kinds: type) -> tuple[Any, ...]:
    """The children of that node class."""
    return tuple(child for child in children if isinstance(child, kinds))


def _first(children: Children, *kinds: type) -> Any:
    """The first child of that node class, or None."""
    return next((child for child in children if isinstance(child, kinds)), None)


def _tokens(children: Children, *types: str) -> list[Token]:
    return [child for child in children if getattr(child, "type", None) in types]


def _is(child: Any, kind: str) -> bool:
    return getattr(child, "type", None) == kind


class Head:
    """`namespace name`, before its opening brace."""

    __slots__ = ("end", "name", "start")

    def __init__(self, name: tree.Name, start: int) -> None:
        self.name = name
        self.start = start
        self.end = name.end


class Builder:
    """One method for each rule or alias of `cdl.lark`; `children` as passed by lark."""

    # Lists

    def specification(self, children: Children) -> tuple[tree.Item, ...]:
        return tuple(children)

    def item(self, children: Children) -> tree.Item:
        specifiers, node, end = children
        return tree.Item(specifiers, node, specifiers.start, end.end_pos)

    def plain_item(self, children: Children) -> tree.Item:
        node, end = children
        return tree.Item(None, node, node.start, end.end_pos)

    def unended_item(self, children: Children) -> tree.Item:
        (node,) = children
        return tree.Item(None, node, node.start, node.end)

    def skipped(self, children: Children) -> tree.Item:
        start = children[0].start_pos
        return tree.Item(None, tree.Skipped(start, start), start, start)

    # Files and name spaces

    def namespace_head(self, children: Children) -> Head:
        keyword, name = children
        return Head(_name(name), keyword.start_pos)

    def namespace_dcl(self, children: Children) -> tree.Namespace:
        head, _, *items, end = children
        return tree.Namespace(head.name, tuple(items), head.start, end.end_pos)

    def import_dcl(self, children: Children) -> tree.Import:
        keyword, _, path, end = children
        return tree.Import(
            path[1:-1], path.type == "ANGLE", keyword.start_pos, end.end_pos
        )

    def import_c_dcl(self, children: Children) -> tree.ImportC:
        header, *definitions = _nodes(children, tree.Text)
        return tree.ImportC(
            header,
            definitions[0] if definitions else None,
            _start(children[0]),
            _end(children[-1]),
        )

    def generate_dcl(self, children: Children) -> tree.Generate:
        keyword, _, plugin, target, argument, end = children
        return tree.Generate(
            _name(plugin), target, argument, keyword.start_pos, end.end_pos
        )

    # Types

    def typedef_dcl(self, children: Children) -> tree.Typedef:
        keyword, *specifiers, type_, declarators = children
        return tree.Typedef(
            specifiers[0] if specifiers else None,
            type_,
            declarators,
            keyword.start_pos,
            declarators[-1].end,
        )

    def type_dcl(self, children: Children) -> tree.TypeStatement:
        (type_,) = children
        return tree.TypeStatement(type_, type_.start, type_.end)

    def const_dcl(self, children: Children) -> Any:
        return children[0]

    def declaration(self, children: Children) -> tree.Declaration:
        type_, declarators = children
        return tree.Declaration(type_, declarators, type_.start, declarators[-1].end)

    def init_declarators(self, children: Children) -> tuple[Any, ...]:
        return tuple(children)

    def declarators(self, children: Children) -> tuple[Any, ...]:
        return tuple(children)

    def init_declarator(self, children: Children) -> tree.InitDeclarator:
        declarator, *rest = children
        value = rest[1] if rest else None
        end = value.end if value is not None else declarator.end
        return tree.InitDeclarator(declarator, value, declarator.start, end)

    def qualified_type(self, children: Children) -> tree.QualifiedType:
        type_ = children[-1]
        qualifiers = tuple(children[:-1])
        return tree.QualifiedType(qualifiers, type_, children[0].start, type_.end)

    def qualifier(self, children: Children) -> tree.Name:
        return _keyword(children[0])

    def basic_type(self, children: Children) -> tree.BasicType:
        *sign, word = children
        kind = _SCALARS[_word(word)]
        return tree.BasicType(
            kind,
            kind is Scalar.CHAR and word.type == "CHAR",
            _word(sign[0]) if sign else None,
            _start(children[0]),
            word.end_pos,
        )

    def typedef_name(self, children: Children) -> tree.TypedefName:
        name = _name(children[0])
        return tree.TypedefName(name, name.start, name.end)

    def descriptor(self, children: Children) -> tree.DescriptorOf:
        keyword, _, signature, end = children
        return tree.DescriptorOf(signature, keyword.start_pos, end.end_pos)

    def struct_type(self, children: Children) -> tree.StructSpecifier:
        tag = _tokens(children, "IDENT")
        members = (
            _nodes(children, tree.MemberItem) if _tokens(children, "LBRACE") else None
        )
        return tree.StructSpecifier(
            _name(tag[0]) if tag else None,
            members,
            _start(children[0]),
            _end(children[-1]),
        )

    def member(self, children: Children) -> tree.MemberItem:
        *specifiers, type_, declarators, end = children
        first = specifiers[0] if specifiers else type_
        return tree.MemberItem(
            specifiers[0] if specifiers else None,
            type_,
            declarators,
            first.start,
            end.end_pos,
        )

    def enum_keyword(self, children: Children) -> tree.Name:
        return _keyword(children[0])

    def enum_type(self, children: Children) -> tree.EnumSpecifier:
        keyword = children[0]
        tag = _tokens(children, "IDENT")
        enumerators = (
            _nodes(children, tree.Enumerator) if _tokens(children, "LBRACE") else None
        )
        return tree.EnumSpecifier(
            keyword.text,
            _name(tag[0]) if tag else None,
            enumerators,
            keyword.start,
            _end(children[-1]),
        )

    def enumerator(self, children: Children) -> tree.Enumerator:
        return tree.Enumerator(
            _name(children[0]), children[2] if len(children) > 1 else None
        )

    # Declarators

    def declarator(self, children: Children) -> tree.Declarator:
        *pointers, direct = children
        if not pointers:
            whole: tree.Declarator = direct
            return whole
        return tree.Declarator(
            tuple(pointers),
            direct.inner,
            direct.suffixes,
            pointers[0].start,
            direct.end,
        )

    def direct_declarator(self, children: Children) -> tree.Declarator:
        first = children[0]
        inner = first if isinstance(first, tree.Declarator) else _name(first)
        suffixes = tuple(children[1:])
        end = suffixes[-1].end if suffixes else inner.end
        return tree.Declarator((), inner, suffixes, inner.start, end)

    def group_declarator(self, children: Children) -> tree.Declarator:
        opening, inner, closing = children
        return tree.Declarator((), inner, (), opening.start_pos, closing.end_pos)

    def array_suffix(self, children: Children) -> tree.ArraySuffix:
        opening, *size, closing = children
        return tree.ArraySuffix(
            size[0] if size else None, opening.start_pos, closing.end_pos
        )

    def pointer(self, children: Children) -> tree.Pointer:
        star, *qualifier = children
        return tree.Pointer(
            qualifier[0] if qualifier else None, star.start_pos, _end(children[-1])
        )

    def parameters(self, children: Children) -> tree.Parameters:
        opening, *items, closing = children
        return tree.Parameters(tuple(items), opening.start_pos, closing.end_pos)

    def parameter(self, children: Children) -> tree.Parameter:
        first, last = children[0], children[-1]
        specifiers = first if isinstance(first, tree.Specifiers) else None
        declarator = last if isinstance(last, tree.Declarator) else None
        type_ = first if specifiers is None else children[1]
        return tree.Parameter(specifiers, type_, declarator, first.start, last.end)

    def type_name(self, children: Children) -> tree.TypeName:
        type_, *declarator = children
        return tree.TypeName(
            type_, declarator[0] if declarator else None, type_.start, children[-1].end
        )

    def abstract_declarator(self, children: Children) -> tree.Declarator:
        pointers = _nodes(children, tree.Pointer)
        direct = _first(children, tree.Declarator)
        return tree.Declarator(
            pointers,
            direct.inner if direct is not None else None,
            direct.suffixes if direct is not None else (),
            children[0].start,
            children[-1].end,
        )

    def direct_abstract(self, children: Children) -> tree.Declarator:
        inner = _first(children, tree.Declarator)
        suffixes = tuple(child for child in children if child is not inner)
        return tree.Declarator((), inner, suffixes, children[0].start, children[-1].end)

    def group_abstract(self, children: Children) -> tree.Declarator:
        return self.group_declarator(children)

    # Expressions

    def aggregate(self, children: Children) -> tree.Aggregate:
        opening, *items, closing = children
        return tree.Aggregate(tuple(items), opening.start_pos, closing.end_pos)

    def c_exp(self, children: Children) -> tree.CExp:
        keyword, _, text, end = children
        return tree.CExp(text, keyword.start_pos, end.end_pos)

    def conditional(self, children: Children) -> tree.Conditional:
        condition, yes, _, no = children
        return tree.Conditional(condition, yes, no, condition.start, no.end)

    def chain(self, children: Children) -> tree.Chain:
        pairs = tuple(
            (str(children[i]), children[i + 1]) for i in range(1, len(children), 2)
        )
        return tree.Chain(children[0], pairs, children[0].start, children[-1].end)

    def cast(self, children: Children) -> tree.Cast:
        opening, type_, _, operand = children
        return tree.Cast(type_, operand, opening.start_pos, operand.end)

    def unary_op(self, children: Children) -> tree.Unary:
        operator, operand = children
        return tree.Unary(str(operator), operand, operator.start_pos, operand.end)

    def postfix_chain(self, children: Children) -> tree.Postfix:
        operand, *suffixes = children
        return tree.Postfix(operand, tuple(suffixes), operand.start, suffixes[-1].end)

    def postfix_part(self, children: Children) -> tree.Subscript | tree.Name:
        if len(children) == 2:
            return _name(children[1])
        return self.subscript(children)

    def group(self, children: Children) -> tree.Group:
        opening, inner, closing = children
        return tree.Group(inner, opening.start_pos, closing.end_pos)

    def scoped_name(self, children: Children) -> tree.ScopedName:
        first = children[0]
        if len(children) == 1:
            name = _name(first)
            return tree.ScopedName((name,), False, name.start, name.end)
        parts = tuple(_name(token) for token in children if token.type != "SCOPE")
        return tree.ScopedName(
            parts, first.type == "SCOPE", first.start_pos, parts[-1].end
        )

    def number(self, children: Children) -> tree.Number:
        (token,) = children
        return tree.Number(str(token), token.start_pos, token.end_pos)

    def character(self, children: Children) -> tree.Character:
        (token,) = children
        return tree.Character(token[1:-1], token.start_pos, token.end_pos)

    def boolean(self, children: Children) -> tree.Boolean:
        (token,) = children
        return tree.Boolean(token.type == "TRUE", token.start_pos, token.end_pos)

    def text(self, children: Children) -> tree.Text:
        parts = tuple(
            tree.TextPart(token[1:-1], token.start_pos + 1, token.end_pos - 1)
            for token in children
        )
        return tree.Text(parts, _start(children[0]), _end(children[-1]))

    # Specifiers

    def specifiers(self, children: Children) -> tree.Specifiers:
        opening, *items, closing = children
        known = tuple(item for item in items if item.word in TERMINALS)
        broken = len(known) < len(items)
        return tree.Specifiers(known, broken, opening.start_pos, closing.end_pos)

    def specifier(self, children: Children) -> tree.Specifier:
        word, *rest = children
        arguments = tuple(child for child in rest if not isinstance(child, str))
        return tree.Specifier(str(word), arguments, word.start_pos, _end(children[-1]))

    def name(self, children: Children) -> tree.Name:
        return _name(children[0])

    def plugin(self, children: Children) -> tree.Name:
        return tree.Name("".join(children), _start(children[0]), _end(children[-1]))

    def allocation(self, children: Children) -> tree.Allocation:
        *path, operator, value = children
        names = tuple(_name(token) for token in _tokens(path, "IDENT"))
        return tree.Allocation(
            names,
            _first(path, tree.Subscript),
            str(operator),
            value,
            names[0].start,
            value.end,
        )

    def restriction(self, children: Children) -> tree.Restriction:
        names = tuple(_name(token) for token in _tokens(children, "IDENT"))
        return tree.Restriction(
            names,
            _nodes(children, tree.ScopedName),
            names[0].start,
            _end(children[-1]),
        )

    def subscript(self, children: Children) -> tree.Subscript:
        opening, *index, closing = children
        return tree.Subscript(
            index[0] if index else None, opening.start_pos, closing.end_pos
        )

    # Signatures and celltypes

    def signature_dcl(self, children: Children) -> tree.Signature:
        return tree.Signature(*self._block(children))

    def celltype_dcl(self, children: Children) -> tree.Celltype:
        return tree.Celltype(*self._block(children))

    def composite_dcl(self, children: Children) -> tree.Composite:
        return tree.Composite(*self._block(children))

    def region_dcl(self, children: Children) -> tree.Region:
        return tree.Region(*self._block(children))

    def _block(
        self, children: Children
    ) -> tuple[tree.Name, tuple[tree.Item, ...], int, int]:
        keyword, name, _, *items, end = children
        return _name(name), tuple(items), keyword.start_pos, end.end_pos

    def function(self, children: Children) -> tree.Function:
        type_, declarator = children
        return tree.Function(type_, declarator, type_.start, declarator.end)

    def port(self, children: Children) -> tree.Port:
        keyword, signature, name, *subscript = children
        return tree.Port(
            _word(keyword),
            signature,
            _name(name),
            subscript[0] if subscript else None,
            None,
            keyword.start_pos,
            _end(children[-1]),
        )

    def joined_port(self, children: Children) -> tree.Port:
        keyword, signature, name, _, target = children
        return tree.Port(
            _word(keyword),
            signature,
            _name(name),
            None,
            target,
            keyword.start_pos,
            target.end,
        )

    def port_of(self, children: Children) -> tree.PortOf:
        owner, _, port = children
        return tree.PortOf(owner, _name(port), None, owner.start, port.end_pos)

    def attributes(self, children: Children) -> tree.Attributes:
        keyword, _, *items, end = children
        return tree.Attributes(
            _word(keyword), tuple(items), keyword.start_pos, end.end_pos
        )

    def require(self, children: Children) -> tree.Require:
        keyword, target = children
        return tree.Require(None, target, keyword.start_pos, target.end)

    def named_require(self, children: Children) -> tree.Require:
        keyword, name, _, target = children
        return tree.Require(_name(name), target, keyword.start_pos, target.end)

    def factory(self, children: Children) -> tree.Factory:
        keyword, _, *items, end = children
        return tree.Factory(
            _word(keyword), tuple(items), keyword.start_pos, end.end_pos
        )

    def factory_call(self, children: Children) -> tree.FactoryCall:
        function, _, file, format_, *arguments, end = children
        return tree.FactoryCall(
            _name(function),
            file,
            format_,
            tuple(arguments),
            function.start_pos,
            end.end_pos,
        )

    # Cells and composites

    def cell_dcl(self, children: Children) -> tree.Cell:
        keyword, celltype, name, *body = children
        return tree.Cell(
            celltype,
            _name(name),
            tuple(body[1:-1]) if body else None,
            keyword.start_pos,
            _end(children[-1]),
        )

    def join(self, children: Children) -> tree.Join:
        name, *subscript, _, value = children
        return tree.Join(
            _name(name),
            subscript[0] if subscript else None,
            value,
            name.start_pos,
            value.end,
        )

    def composite_join(self, children: Children) -> tree.Join:
        name, *subscript, _, keyword, _, outer = children
        value = tree.OfComposite(_name(outer), keyword.start_pos, outer.end_pos)
        return tree.Join(
            _name(name),
            subscript[0] if subscript else None,
            value,
            name.start_pos,
            value.end,
        )

    def reverse_join(self, children: Children) -> tree.ReverseJoin:
        name, *left, operator, owner, _, port = children[: _after_port(children)]
        right = children[_after_port(children) :]
        target = tree.PortOf(
            owner,
            _name(port),
            right[0] if right else None,
            owner.start,
            _end(children[-1]),
        )
        assert _is(operator, "LESS_EQUAL")
        return tree.ReverseJoin(
            _name(name), left[0] if left else None, target, name.start_pos, target.end
        )

    def export(self, children: Children) -> tree.Export:
        port, *_, name = children
        return tree.Export(_name(port), _name(name), port.start_pos, name.end_pos)

    def entry_export(self, children: Children) -> tree.EntryExport:
        name, cell, port = _tokens(children, "IDENT")
        return tree.EntryExport(
            _name(name), _name(cell), _name(port), _start(children[0]), port.end_pos
        )

    # Statements of graphical editors

    def tool_info(self, children: Children) -> tree.ToolInformation:
        return tree.ToolInformation(
            str(children[0]), _start(children[0]), _end(children[-1])
        )

    def json_object(self, children: Children) -> tree.Skipped:
        return tree.Skipped(_start(children[0]), _end(children[-1]))

    json_property = json_array = location = port_location = bar = json_object


def _after_port(children: Children) -> int:
    """The position for the right subscript of a reverse join."""
    dot = next(i for i, child in enumerate(children) if _is(child, "DOT"))
    return dot + 2
