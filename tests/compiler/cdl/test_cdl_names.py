"""The table of a unit: scopes, declarations, name clashes."""

from cdl_stages import analysed


def test_declarations_in_the_order_of_the_text() -> None:
    table, found = analysed("typedef int32_t A; namespace n { typedef A B; };")
    assert not found
    assert [entity.name for entity in table.declarations] == [("A",), ("n", "B")]
    assert table.root.scopes["n"].own("B") is table.declarations[1]


def test_a_name_space_can_be_opened_again() -> None:
    table, found = analysed(
        "namespace n { typedef int32_t A; }; namespace n { typedef A B; };"
    )
    assert not found
    assert list(table.root.scopes["n"].entities) == ["A", "B"]


def test_a_name_is_known_behind_its_declaration_only() -> None:
    _, found = analysed("const int32_t A = B; const int32_t B = 1;")
    assert found == ["'B' is unknown here"]


def test_a_name_is_taken_once() -> None:
    table, found = analysed(
        "const int32_t A = 1; struct tagA { int32_t x; }; const int32_t A = 2;"
    )
    assert found == ["'A' is a constant already"]
    assert [d.name for d in table.model()] == [("A",), ("tagA",)]


def test_what_a_missing_import_may_declare_is_no_error() -> None:
    table, _ = analysed("typedef int32_t A;")
    assert not table.incomplete
    assert not table.excused
    table.lacking = True
    assert table.incomplete
    assert table.excused
