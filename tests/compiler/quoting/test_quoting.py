"""Quoting of any text: its language's own parser returns the same text."""

from __future__ import annotations

import ast
import io
import json
import shlex
import tokenize
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rtgen.compiler.backends.kit.python_text import fit_text
from rtgen.compiler.backends.kit.quoting import (
    UnquotableError,
    idl,
    properties,
    python,
    scripts,
    typescript,
    xml,
)
from rtgen.compiler.frontends.idl import load as load_idl
from rtgen.compiler.model import Const
from rtgen.runtime.rtc import conf_file

HOSTILE = (
    "",
    "plain",
    '"""',
    '"""""',
    "'''#",
    "\\",
    'ends in a quote"',
    "a\nimport os",
    "a\r\nb\x0bc\x0cd\x85e\u2028f",
    "{{ 7 * 7 }}{% if %}",
    '"); import os; os.system("x")#',
    "$(id) `id` ${HOME} %PATH% & | > ;",
    "²ﬁ℘·",
    "\ufeff\x00\x1b[2J",
    "]]>--><!--",
    "a -- b -",
    "*/ /* //",
    "x = 1 # y",
    " leading and trailing ",
    "[section]",
    "# \u202e) tixe ( \u2066",
    "a | b if c else d for e in f, (g, h): i" * 6,
)

text = st.text(
    st.one_of(st.sampled_from("\"'\\\n\r\t #`$%(){}[];:=,|-/*<>&"), st.characters())
) | st.sampled_from(HOSTILE)


def hostile(test):  # type: ignore[no-untyped-def]
    """Add the texts that once failed to the drawn ones of a test."""
    for each in HOSTILE:
        test = example(each)(test)
    return given(text)(test)


@hostile
def test_python_string(value: str) -> None:
    assert ast.literal_eval(python.string_literal(value)) == value


@hostile
def test_python_docstring(value: str) -> None:
    body = python.docstring(value, 4)
    module = f'class C:\n{body}    """A second string."""\n'
    [made] = ast.parse(module).body
    assert isinstance(made, ast.ClassDef)
    assert len(made.body) == 1 + bool(body)
    assert fit_text(module).split() == module.split()


@pytest.mark.parametrize("value", ["", " ", "\n\t", "\ufeff", "\u2028", "\x1b", "\x85"])
def test_a_blank_documentation_comment_leaves_no_body_empty(value: str) -> None:
    assert python.docstring(value, 4) == ""
    assert python.docstring(value, 4, "`A::B`.") == '    """`A::B`."""\n'


@hostile
def test_python_text_within_a_docstring(value: str) -> None:
    [made] = ast.parse(f'"""Serves `{python.in_docstring(value)}` to all."""\n').body
    assert isinstance(made, ast.Expr)
    assert isinstance(made.value, ast.Constant)


@hostile
def test_python_comment(value: str) -> None:
    source = f"# {python.comment_text(value)}\n"
    kinds = {
        token.type for token in tokenize.generate_tokens(io.StringIO(source).readline)
    }
    assert kinds == {tokenize.COMMENT, tokenize.NL, tokenize.ENDMARKER}


@hostile
def test_what_python_takes_unquoted_is_no_statement_and_no_call(value: str) -> None:
    try:
        inserted = python.quote(value)
    except UnquotableError:
        return
    assert inserted == value
    try:
        tree = ast.parse(inserted.strip())
    except SyntaxError:
        return
    effects = (ast.Call, ast.Import, ast.ImportFrom, ast.Assign, ast.Delete)
    assert not any(isinstance(node, effects) for node in ast.walk(tree))


@pytest.mark.parametrize(
    "value", ["import os", "x()", "a\nb", "'", '"', "a = b", "a; b", "# a", "a\\"]
)
def test_python_refuses_what_is_neither_code_nor_a_name(value: str) -> None:
    with pytest.raises(UnquotableError):
        python.quote(value)
    with pytest.raises(UnquotableError):
        python.quote(scripts.shell_word(value))
    assert python.quote(python.Python(value)) == value


@hostile
def test_shell_word(value: str) -> None:
    if "\0" in value:
        with pytest.raises(UnquotableError):
            scripts.shell_word(value)
    else:
        assert shlex.split(scripts.shell_word(value)) == [value]


@hostile
def test_batch_text_has_nothing_that_the_processor_expands(value: str) -> None:
    for shown in (scripts.batch_comment(value), _or_none(scripts.quote_batch, value)):
        assert shown is None or not set(shown) & set('%!&|<>^"\n\r')


@hostile
def test_typescript_string(value: str) -> None:
    assert json.loads(typescript.string(value)) == value
    assert json.loads(f"[{typescript.string(value)}]") == [value]


@hostile
def test_typescript_comments_end_where_they_shall(value: str) -> None:
    shown = typescript.comment(value, 2)
    assert not shown or (shown.find("*/"), shown[-1]) == (len(shown) - 3, "\n")
    head = typescript.line_comment([python.comment_text(value)])
    assert not set(head) & set("\n\r\u2028\u2029")


@hostile
def test_what_typescript_takes_unquoted_is_a_name_or_path(value: str) -> None:
    shown = _or_none(typescript.quote, value)
    assert shown is None or not set(shown) & set(" ;,()[]{}'\"`=<>*-\\\n\r\u2028\u2029")


@hostile
def test_ruby_string(value: str) -> None:
    body = scripts.ruby_string(value)[1:-1]
    plain = body.replace("\\\\", "").replace("\\'", "")
    assert "'" not in plain
    assert "\\" not in plain
    assert body.replace("\\'", "'").replace("\\\\", "\\").count("'") == value.count("'")


@hostile
def test_conf_value_is_one_line_that_openrtm_reads_back(value: str) -> None:
    if (made := _or_none(properties.conf_value, value)) is None:
        return
    [line] = f"conf.default.key: {made}".splitlines()
    assert not line.endswith("\\")
    assert conf_file.parse(line).sets == {"default": {"key": value}}


@hostile
def test_conf_key_ends_where_the_value_begins(value: str) -> None:
    if (made := _or_none(properties.conf_key, value)) is None:
        return
    [line] = f"{made}: text".splitlines()
    assert line.replace("=", ":").partition(":")[0].strip() == value
    assert not line.startswith(("#", "!"))


@hostile
def test_xml_text_and_attribute(value: str) -> None:
    if (made := _or_none(xml.quote_xml, value)) is None:
        assert xml.NOT_IN_XML.search(value)
        return
    read = ElementTree.fromstring(f'<a b="{made}">{made}</a>')
    assert (read.get("b"), read.text or "") == (value, value)


@hostile
def test_xml_comment(value: str) -> None:
    read = ElementTree.fromstring(f"<a><!-- {xml.xml_comment(value)}--><b/></a>")
    assert [child.tag for child in read] == ["b"]


def _or_none(quote, value):  # type: ignore[no-untyped-def]
    try:
        return quote(value)
    except UnquotableError:
        return None


@hostile
def test_idl_string_and_repository_id(value: str) -> None:
    """rtgen reads the IDL that it writes: the id, the constant, nothing else."""
    value = "".join(c for c in value if "\0" < c <= "\xff")
    name = (
        "".join(c for c in value if c.isprintable() and c not in '\\"') or "IDL:a:1.0"
    )
    literal = idl.characters(value, wide=False)
    text = (
        f"/** {' '.join(idl.comment_lines(value))} */\ninterface A {{}};\n"
        f"interface B {{}};\ninterface D {{}};\n"
        f"{idl.repository_id('A', name)}\n{idl.repository_id('B', literal)}\n"
        f'{idl.repository_id("D", value)}\nconst string C = "{literal}";\n'
    )
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.idl"
        path.write_text(text, encoding="utf-8")
        model = load_idl([path], root=Path(folder)).model
    first, second, _, constant = model.declarations
    assert isinstance(constant, Const)
    assert (first.repository_id, second.repository_id) == (name, literal)
    assert constant.value == value
