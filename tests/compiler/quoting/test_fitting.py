"""The line fitter does not treat text in a literal as code."""

from __future__ import annotations

import ast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtgen.compiler.backends.kit.python_text import (
    Bracketed,
    fit,
    fit_bracketed,
    fit_text,
    tuple_of,
)
from rtgen.compiler.backends.kit.quoting.python import docstring, string_literal

WORDS = (" | ", ": ", " if ", " else ", " for ", ", ", " = ", "(", ")", "[", "{", "#")
texts = st.lists(
    st.sampled_from((*WORDS, '"', "'", "\\", "\n", "word", '"""', "  # fmt: skip")),
    max_size=60,
).map("".join)


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "statement",
    [
        "x = f({0})",
        "x = f(a, description={0}, other={1})",
        "x: T = {0}",
        "x = {0} if y else {1}",
        "return g(a={0})",
        "raise E({0})",
        "x = [{0}]",
        "x = field(default_factory=lambda: [{0}, {1}])",
        "self.a = self.b({0}, C)",
        "f({0})",
    ],
)
@given(st.data())
def test_a_split_statement_is_the_same_statement(
    statement: str, data: st.DataObject
) -> None:
    first, second = data.draw(texts), data.draw(texts)
    flat = statement.format(string_literal(first), string_literal(second))
    assert ast.dump(ast.parse(fit(flat))) == ast.dump(ast.parse(flat))


@given(texts, texts)
def test_a_docstring_does_not_hide_the_statements_behind_it(
    first: str, second: str
) -> None:
    value = string_literal(f"{second} | {second}")
    module = f"{docstring(first, 0)}x = f(aaaaaaaaaaaaaaaa={value})\n"
    assert ast.dump(ast.parse(fit_text(module))) == ast.dump(ast.parse(module))


items = st.recursive(
    st.one_of(
        st.text("ab", min_size=1, max_size=90),
        texts.map(string_literal),
        st.integers(1, 40).map(lambda n: f"a=b({', '.join(['word'] * n)})"),
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=5).map(lambda some: Bracketed('"key": call(', some)),
        st.lists(inner, max_size=5).map(lambda some: Bracketed("x=[", some, "]")),
        st.lists(inner, max_size=5).map(tuple_of),
    ),
    max_leaves=12,
)


@pytest.mark.sampled(0)
@given(
    st.text("a_b", min_size=1, max_size=90),
    st.lists(items, max_size=8),
    st.sampled_from((0, 4, 8)),
)
def test_a_call_is_fitted_from_its_arguments_as_from_its_text(
    name: str, arguments: list[str | Bracketed], indent: int
) -> None:
    call = Bracketed(f"x: T = {name}(", arguments)
    assert fit_text(fit_bracketed(call, indent)) == fit_text(" " * indent + call.flat)
