"""The parser: the tree of a text, positions, and recovery from errors."""

import pytest
from idl_stages import parsed

from rtgen.compiler.frontends.idl.syntax import tree
from rtgen.compiler.model import Direction, Primitive


def nodes(text: str) -> list[tree.Node]:
    _, items, messages = parsed(text)
    assert not messages
    return [item.node for item in items]


def test_the_tree_is_the_text_as_written() -> None:
    [module] = nodes("module M { typedef sequence<Unknown, 3> A; };")
    assert isinstance(module, tree.Module)
    assert module.name.text == "M"
    [item] = module.body.items
    assert isinstance(item.node, tree.Typedef)
    sequence = item.node.type
    assert isinstance(sequence, tree.Sequence)
    assert str(sequence.element) == "Unknown"
    assert isinstance(sequence.bound, tree.Number)
    assert sequence.bound.text == "3"


def test_declarators_share_a_type() -> None:
    [struct] = nodes("struct S { long a, b[2][3]; };")
    assert isinstance(struct, tree.Struct)
    [item] = struct.body.items
    assert isinstance(item.node, tree.Member)
    assert isinstance(item.node.type, tree.BasicType)
    assert item.node.type.kind is Primitive.LONG
    assert [(d.name.text, len(d.dimensions)) for d in item.node.declarators] == [
        ("a", 0),
        ("b", 2),
    ]


def test_an_operation() -> None:
    [interface] = nodes(
        "interface I { oneway void f(in long a, out string b) raises (E); };"
    )
    assert isinstance(interface, tree.Interface)
    operation = interface.body.items[0].node
    assert isinstance(operation, tree.Operation)
    assert operation.oneway
    assert [p.direction for p in operation.parameters] == [Direction.IN, Direction.OUT]
    assert operation.raises is not None
    assert [str(name) for name in operation.raises.names] == ["E"]


def test_operators_of_one_precedence_are_a_chain() -> None:
    [const] = nodes("const long A = 1 + 2 * 3 - 4;")
    assert isinstance(const, tree.Const)
    assert isinstance(const.value, tree.Chain)
    assert [operator for operator, _ in const.value.rest] == ["+", "-"]
    product = const.value.rest[0][1]
    assert isinstance(product, tree.Chain)
    assert [operator for operator, _ in product.rest] == ["*"]


def test_escaped_names_lose_their_underscore() -> None:
    [struct] = nodes("struct _struct { long _long; };")
    assert isinstance(struct, tree.Struct)
    assert struct.name.text == "struct"


def test_annotations_belong_to_their_item() -> None:
    _, [item], messages = parsed('@final @unit("m") struct S { long a; };')
    assert not messages
    assert [a.name for a in item.annotations] == ["final", "unit"]
    [argument] = item.annotations[1].arguments
    assert argument.name is None
    assert isinstance(argument.value, tree.Text)


def test_places_are_offsets_into_the_text() -> None:
    unit, [item], _ = parsed("  const long A = 1;\n")
    assert isinstance(item.node, tree.Const)
    name = item.node.name
    assert unit.text[name.start : name.end] == "A"
    assert unit.span(name.start, name.end).column == 14


@pytest.mark.parametrize(
    ("text", "kinds"),
    [
        ("struct A { long; }; struct B { long b; };", ["Struct", "Struct"]),
        ("struct A { long a }; struct B { long b; };", ["Struct", "Struct"]),
        ("const long = 3; typedef long T;", ["Skipped", "Typedef"]),
    ],
)
def test_declarations_behind_an_error_are_read(text: str, kinds: list[str]) -> None:
    _, items, messages = parsed(text)
    assert len(messages) == 1
    assert [type(item.node).__name__ for item in items] == kinds


def test_what_a_skipped_declaration_may_have_declared_is_noted() -> None:
    unit, items, messages = parsed("typedef long Broken[; typedef short Whole;")
    assert len(messages) == 1
    assert "broken" in unit.maybe_declared
    assert [type(item.node).__name__ for item in items] == ["Skipped", "Typedef"]
