"""Text to the tree, and recovery from syntax errors."""

from cdl_stages import parsed

from rtgen.compiler.frontends.cdl.syntax import statements, tree


def test_statements_in_order() -> None:
    unit, errors = parsed("typedef int32_t A; signature s { A f(void); }; cell t c {};")
    assert not errors
    kinds = [type(item.node) for item in unit.items]
    assert kinds == [tree.Typedef, statements.Signature, statements.Cell]


def test_one_error_hides_no_other_statement() -> None:
    unit, errors = parsed(
        "const int32_t A = ;\ntypedef int32_t B;\nconst int32_t C = ;\n"
    )
    kinds = [type(item.node) for item in unit.items]
    assert kinds == [statements.Skipped, tree.Typedef, statements.Skipped]
    assert [error.span.line for error in errors if error.span] == [1, 3]
    assert {"A", "C"} <= unit.maybe_declared


def test_a_missing_semicolon_is_supplied() -> None:
    unit, errors = parsed("typedef int32_t A\ntypedef int32_t B;")
    assert len(unit.items) == 2
    assert [error.message for error in errors] == ["a ';' is missing here"]
