"""Layouts of OpaqueRPC messages: their steps in wire order, and refusals with positions."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.kit.limits import MAX_VALUES
from rtgen.compiler.layouts.tdr import (
    Branch,
    Counted,
    FunctionLayout,
    Part,
    Payload,
    Reserve,
    Run,
    SignatureLayout,
    Step,
    TransferError,
)
from rtgen.compiler.layouts.tdr_messages import layout_of, problems
from rtgen.compiler.model.tecs import Signature, TecsUnit

ALLOCATOR = (
    "signature sAlloc { ER alloc( [in] int32_t size, [out] void **p );"
    " ER dealloc( [in] const void *p ); };"
)
POINT = "struct tagP { int16_t x; uint8_t y; };"
PAIR = "struct tagPair { struct tagP left; struct tagP right; };"
NAME = "struct tagName { int8_t id; [string] char_t *text; };"


def parsed(parameters: str, before: str, head: str) -> tuple[TecsUnit, Signature]:
    """Return a unit whose third line is a signature with one function."""
    text = f"{ALLOCATOR}\n{before}\nsignature sOne {{ {head}({parameters}); }};"
    unit, _ = read_text(text, "one.cdl")
    names = {d.name: d for d in unit.declarations if isinstance(d, Signature)}
    return unit, names["sOne",]


def whole(parameters: str, before: str = "", head: str = "ER f") -> SignatureLayout:
    return layout_of(*parsed(parameters, before, head))


def function(parameters: str, before: str = "", head: str = "ER f") -> FunctionLayout:
    (found,) = whole(parameters, before, head).functions
    return found


def written(steps: Iterable[Step] | None) -> str:
    """Return the steps: letters of runs, `a[]` elements, `a{}` parts, `a?(...)` branches."""
    words = []
    for step in steps or ():
        match step:
            case Run():
                letters = (f"{n}*{k}" if n != 1 else k for k, n in step.kinds)
                words.append(" ".join(letters))
            case Payload(item):
                words.append(f"{item.name}[]")
            case Part(item):
                words.append(f"{item.name}{{}}")
            case Branch(item, inner):
                words.append(f"{item.name}?({written(inner)})")
            case Reserve(item):
                words.append(f"reserve {item.name}")
    return " | ".join(words)


@pytest.mark.parametrize(
    ("parameters", "before", "request_steps", "reply_steps"),
    [
        ("void", "", "H H H", "H n H"),
        ("[in] int8_t a, [in] uint64_t b", "", "H H b Q H", "H n H"),
        ("[in] int8_t a[3], [in] uint8_t b[3]", "", "H H 3b 3s H", "H n H"),
        ("[in] uint16_t a[3]", "", "H H 3H H", "H n H"),
        ("[in] int16_t a[2][3]", "", "H H 2*3h H", "H n H"),
        ("[in] int128_t a, [in] uint128_t b", "", "H H 16s 16s H", "H n H"),
        ("[in] int128_t a[2], [in] uint128_t b[3]", "", "H H 2*16s 3*16s H", "H n H"),
        ("[in] struct tagP a[2]", POINT, "H H 2*hB H", "H n H"),
        ("[in] struct tagPair a[2]", POINT + PAIR, "H H 2*hBhB H", "H n H"),
        ("[in] struct tagI a[2]", "struct tagI { int32_t i; };", "H H 2*i H", "H n H"),
        ("[in] struct tagName a", NAME, "H H | a{} | H", "H n H"),
        ("[in] struct tagName a[2]", NAME, "H H | a{} | H", "H n H"),
        (
            "[in,string] const char_t *s, [in] int8_t k",
            "",
            "H H i | s[] | b H",
            "H n H",
        ),
        ("[in,string,nullable] const char_t *s", "",
         "H H b | s?(i | s[]) | H", "H n H"),
        ("[in,nullable] const int32_t *s", "", "H H b | s?(i) | H", "H n H"),
        ("[out,nullable] int32_t *s", "", "H H b H", "H n | s?(i) | H"),
        ("[inout,nullable] int32_t *s", "", "H H b | s?(i) | H", "H n | s?(i) | H"),
        ("[out] int32_t *s", "", "H H H", "H n i H"),
        # A size travels before the values that depend on it; others keep their order.
        ("[in] int8_t k, [in,size_is(n)] const int32_t *a, [in] int16_t n", "",
         "H H h b | a[] | H", "H n H"),
        ("[in,size_is(n)] const struct tagName *a, [in] int16_t n", NAME,
         "H H h | a{} | H", "H n H"),
        # The server reserves memory whose size is known.
        ("[out,size_is(n)] int32_t *a, [in] int16_t n", "",
         "H H h H | reserve a", "H n | a[] | H"),
        ("[out,string(n)] char_t *a, [in] int16_t n", "",
         "H H h H | reserve a", "H n i | a[] | H"),
        ("[out,size_is(4),count_is(*n)] int32_t *a, [out] int16_t *n", "",
         "H H H | reserve a", "H n h | a[] | H"),
        ("[out,size_is(*n)] int32_t *a, [out] int16_t *n", "", "H H H", "H n h | a[] | H"),
        ("[out,size_is(*m),count_is(*n)] int8_t *a, [out] int8_t *n, [out] int16_t *m",
         "", "H H H", "H n b h | a[] | H"),
        ("[out,size_is(m),count_is(*n)] int8_t *a, [out] int8_t *n, [in] int16_t m", "",
         "H H h H | reserve a", "H n b | a[] | H"),
        ("[inout,size_is(8),count_is(*n)] int8_t *a, [inout] int8_t *n", "",
         "H H b | a[] | H", "H n b | a[] | H"),
        # Sent and received values are pointers to allocated memory.
        ("[send(sAlloc),size_is(n)] int8_t *a, [in] int32_t n", "",
         "H H i | a[] | H", "H n H"),
        ("[receive(sAlloc),size_is(*n)] int8_t **a, [out] int32_t *n", "",
         "H H H", "H n i | a[] | H"),
        ("[receive(sAlloc),string] char_t **a", "", "H H H", "H n i | a[] | H"),
        ("[receive(sAlloc),nullable] int16_t **a", "", "H H H", "H n b | a?(h) | H"),
        ("[in] const void *p", "", "H H H", "H n H"),
    ],
)  # fmt: skip
def test_steps_are_those_of_the_wire(
    parameters: str, before: str, request_steps: str, reply_steps: str
) -> None:
    made = function(parameters, before)
    assert written(made.request) == request_steps
    assert written(made.reply) == reply_steps


def test_the_reply_of_the_paper_has_the_value_last() -> None:
    made = function("[out] int64_t *a, [out,string(4)] char_t *b")
    assert written(made.reply) == "H n q i | b[] | H"
    assert written(made.paper) == "H q i | b[] | n H"


BOUND_BY_REQUEST = (
    "[out] int8_t *n, [out,size_is(b[0]){count}] int16_t *a,"
    " [inout,size_is(4)] uint8_t *b, [out,size_is(a[0])] int32_t *c"
)


def test_what_only_bounds_a_size_is_known_from_the_request() -> None:
    made = function(BOUND_BY_REQUEST.format(count=",count_is(*n)"))
    assert written(made.reply) == "H n b | a[] | b[] | c[] | H"
    unit, signature = parsed(BOUND_BY_REQUEST.format(count=""), "", "ER f")
    (found,) = problems(unit, signature)
    assert found.reason == "the size of 'a' depends on 'b', which comes after it"
    assert found.hint == "declare 'b' before 'a'"


def test_a_oneway_function_has_a_request_alone() -> None:
    made = function("[in] int8_t a", head="[oneway] ER f")
    assert written(made.request) == "H H b H"
    assert made.reply is None
    assert made.paper is None
    assert (made.kept, made.leaves_out) == ((), False)


def test_the_returned_value_has_no_name_and_lies_at_its_function() -> None:
    made = function("void", POINT, "struct tagP f")
    assert made.returned.name == ""
    assert made.returned.span == made.function.span
    assert written(made.reply) == "H h B H"
    assert not made.is_void
    assert function("void", head="void f").is_void


@pytest.mark.parametrize(
    ("parameters", "kept"),
    [
        ("[in] int8_t a", []),
        ("[out] int8_t *a", []),
        ("[in,nullable] const int8_t *a", []),
        ("[out,nullable] int8_t *a", ["a"]),
        ("[inout,nullable] int8_t *a", ["a"]),
        ("[receive(sAlloc),nullable] int8_t **a", []),
        ("[out,size_is(n)] int8_t *a, [in] int8_t n, [in] int8_t m", ["n"]),
        ("[out,string(n)] char_t *a, [in] int8_t n", ["n"]),
        ("[inout,size_is(*n)] int8_t *a, [inout] int8_t *n", ["n"]),
        ("[inout,size_is(m),count_is(*n)] int8_t *a, [inout] int8_t *n, [in] int8_t m",
         ["m"]),
        ("[out,size_is(*n)] int8_t *a, [out] int8_t *n, [in] int8_t m", []),
    ],
)  # fmt: skip
def test_kept_are_the_arguments_that_the_reply_depends_on(
    parameters: str, kept: list[str]
) -> None:
    assert [item.name for item in function(parameters).kept] == kept


@pytest.mark.parametrize(
    ("parameters", "before", "pointers"),
    [
        ("[in] const int8_t *a, [in] int8_t b", "", [True, False]),
        ("[in,size_is(2)] const int8_t *a", "", [False]),
        ("[in,count_is(2)] const int8_t *a", "", [False]),
        ("[in,string] const char_t *a", "", [False]),
        ("[receive(sAlloc)] int8_t **a", "", [True]),
        ("[receive(sAlloc),string] char_t **a", "", [False]),
    ],
)
def test_a_pointer_without_sizes_has_a_single_target(
    parameters: str, before: str, pointers: list[bool]
) -> None:
    made = function(parameters, before)
    assert [item.pointer for item in made.items] == pointers


def test_members_of_structs_have_places_and_pointers() -> None:
    text = "struct tagR { int8_t *one; [size_is(n)] int16_t *more; int8_t n; };"
    made = whole("[in] struct tagR a, [in] struct tagP p", text + POINT)
    record, other = made.records
    assert (record.struct.scoped, other.struct.scoped) == ("tagR", "tagP")
    assert written(record.steps) == "b b | more[]"
    assert [(i.name, i.pointer) for i in record.items] == [
        ("one", True),
        ("more", False),
        ("n", False),
    ]
    columns = [text.index(f"{item.name};") + 1 for item in record.items]
    assert [(i.span.line, i.span.column) for i in record.items] == [
        (2, column) for column in columns
    ]
    assert not record.fixed
    assert other.fixed


STRING_HINT = (
    "a string has elements of char_t, int8_t to int64_t or uint8_t to uint64_t"
)
REFUSED = {
    "an enum": (
        "[in] enum eKind @k", "enum eKind { A };",
        "enum eKind cannot be transferred", "use an integer type",
    ),
    "a function": (
        "[in] const fn *@a", "typedef int32_t (fn)(int32_t);",
        "int32_t(int32_t) cannot be transferred", None,
    ),
    "an array without a size": (
        "[in] int8_t @v[]", "", "an array without a size", None,
    ),
    "a member without a size": (
        "[in] struct tagA a", "struct tagA { int8_t @v[]; };",
        "an array without a size", None,
    ),
    "an enum inside of arrays": (
        "[in] enum eKind @k[2][2]", "enum eKind { A };",
        "enum eKind cannot be transferred", "use an integer type",
    ),
    "an array of enums": (
        "[in,size_is(2)] const enum eKind *@k", "enum eKind { A };",
        "const enum eKind cannot be transferred", "use an integer type",
    ),
    "a struct in itself": (
        "[in] struct tagA a", "struct tagA { struct tagA *@a; };",
        "struct tagA contains itself", None,
    ),
    "a struct that was refused": (
        "[in] struct tagA @a", "struct tagA { [size_is(m)] int8_t *v; };",
        "struct tagA is declared without members", None,
    ),
    "an out string of any length": (
        "[out,string] char_t *@s", "",
        "the string 's' needs a length", "give the size of the buffer: string(n)",
    ),
    "a string of int": (
        "[in,string] const int_t *@s", "", "a string of int", STRING_HINT,
    ),
    "a string of structs": (
        "[in,string] const struct tagP *@s", POINT,
        "a string of const struct tagP", STRING_HINT,
    ),
    "a count without a size": (
        "[out,count_is(*n)] int8_t *@a, [out] int32_t *n", "",
        "'a' has count_is without size_is", "add size_is",
    ),
    "elements without bytes": (
        "[in,size_is(n)] const struct tagV *@v, [in] int32_t n",
        "struct tagV { void *p; };",
        "an array of elements that have no byte", None,
    ),
    "members without bytes": (
        "[in] struct tagA a",
        "struct tagV { void *p; }; struct tagA { struct tagV @v[3]; };",
        "an array of elements that have no byte", None,
    ),
    "a size that goes the other way": (
        "[in,size_is(*n)] const int8_t *@a, [out] int32_t *n", "",
        "the size of 'a' depends on 'n', which comes another way", None,
    ),
    "a size that is in the array": (
        "[in,size_is(a[0])] const int8_t *@a", "",
        "the size of 'a' depends on 'a', which comes another way", None,
    ),
    "sizes that need each other": (
        "[in,size_is(b[0])] const int8_t *@a, [in,size_is(a[0])] const int8_t *b", "",
        "the size of 'a' depends on 'b', which comes after it", "declare 'b' before 'a'",
    ),
    "members that need each other": (
        "[in] struct tagA a",
        "struct tagA { [size_is(n[0])] int8_t *@v; [size_is(v[0])] int8_t *n; };",
        "the size of tagA.v depends on 'n', which does not come before it", None,
    ),
    "a member that needs itself": (
        "[in] struct tagA a", "struct tagA { [size_is(v[0])] int8_t *@v; };",
        "the size of tagA.v depends on 'v', which does not come before it", None,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refusals_say_where_and_why(name: str) -> None:
    """`@` marks the position."""
    parameters, before, reason, hint = REFUSED[name]
    unit, signature = parsed(
        parameters.replace("@", ""), before.replace("@", ""), "ER f"
    )
    (found,) = problems(unit, signature)
    assert (found.reason, found.hint, str(found)) == (reason, hint, reason)
    texts = {2: before, 3: f"signature sOne {{ ER f({parameters}"}
    line, text = next((n, t) for n, t in texts.items() if "@" in t)
    assert (found.span.line, found.span.column) == (line, text.index("@") + 1)
    with pytest.raises(TransferError) as raised:
        layout_of(unit, signature)
    assert raised.value.reason == reason


def test_a_returned_type_is_refused_at_its_function() -> None:
    unit, signature = parsed("void", "enum eKind { A };", "enum eKind f")
    (found,) = problems(unit, signature)
    assert found.reason == "enum eKind cannot be transferred"
    assert found.span == signature.functions[0].span


def test_values_in_place_are_limited() -> None:
    """Numbers count one each; an array of numbers is one value, of structs all of theirs."""
    half = MAX_VALUES // 2
    before = "struct tagB {{ int8_t k; double64_t v[9]; }}; struct tagA {{ {} }};"
    members = f"struct tagB a[{half - 1}]; int8_t b[9]; int32_t c[9];"
    assert whole("[in] struct tagA a", before.format(members))
    unit, signature = parsed(
        "[in] struct tagA a", before.format(members + " int8_t d;"), "ER f"
    )
    (found,) = problems(unit, signature)
    assert found.reason == f"struct tagA has more than {MAX_VALUES:,} values in place"
    assert found.hint == "put less into it, or a size_is array in place of a long one"
    assert found.span.line == 3


def test_a_function_that_is_refused_leaves_the_others() -> None:
    unit, _ = read_text(
        "enum eKind { A }; signature sOne { ER a([in] enum eKind k); ER b([in] int8_t k);"
        " ER c([in] enum eKind k); };"
    )
    signature = next(d for d in unit.declarations if isinstance(d, Signature))
    assert len(list(problems(unit, signature))) == 2


@pytest.mark.parametrize(
    ("scalar", "are_octets"),
    [
        *((name, True) for name in ("char_t", "schar_t", "uchar_t", "uint8_t")),
        *((name, False) for name in ("int8_t", "bool_t", "int16_t", "double64_t")),
    ],
)
def test_arrays_of_octets(scalar: str, are_octets: bool) -> None:
    [item] = function(f"[in,size_is(4)] const {scalar} *p").arguments
    assert isinstance(item.node, Counted)
    assert item.node.is_octets is are_octets


def test_what_is_returned_is_no_pointer() -> None:
    made = function("[in] int8_t a", head="int32_t f")
    assert (made.returned.pointer, made.returned.nullable) == (False, False)


@pytest.mark.parametrize("unit", ["X", "double64_t", "float32_t", "bool_t"])
def test_strings_of_other_units_are_refused(unit: str) -> None:
    before = "struct tagX { int8_t a; }; typedef struct tagX X;" if unit == "X" else ""
    with pytest.raises(TransferError, match="a string of"):
        whole(f"[in,string] const {unit} *p", before)
