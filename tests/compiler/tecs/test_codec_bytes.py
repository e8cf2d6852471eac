"""Bytes computed by hand from `opaque-rpc-wire`, for cases without recorded calls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.layouts.tdr import TransferError
from rtgen.compiler.layouts.tdr_messages import problems
from rtgen.compiler.model.tecs import Signature
from rtgen.runtime.opaque_rpc import (
    E_BOVR,
    E_MAGIC,
    E_NOMEM,
    E_PAR,
    ArgumentError,
    Order,
    ProtocolError,
    ReplyOrder,
    RpcError,
    make_tdr,
)
from rtgen.tools.rpc.codecs import Function, Service

ALLOCATOR = """signature sAlloc { ER alloc( [in] int32_t size, [out] void **p );
  ER dealloc( [in] const void *p ); };
"""


def service(
    function: str,
    before: str = "",
    order: Order = "network",
    reply: ReplyOrder = "tecsgen",
    **widths: int,
) -> Service:
    """Return the service of a signature with one function, after other declarations."""
    text = f"{ALLOCATOR}{before}\nsignature sOne {{ {function} }};"
    unit, found = read_text(text, "one.cdl")
    assert not has_errors(found), [str(d) for d in found]
    signature = next(
        d for d in unit.declarations if isinstance(d, Signature) and d.name == ("sOne",)
    )
    return Service(unit, signature, make_tdr(order, **widths), reply)


def only(made: Service) -> Function:
    return next(iter(made.functions.values()))


@dataclass
class Case:
    """A call in network order; `|` and blanks in the hex are for reading."""

    function: str
    args: dict[str, Any]
    request: str
    reply: str = "561e 00000000 6d5e"
    returned: Any = 0
    outs: dict[str, Any] | None = None
    before: str = ""


POINT = "struct tagPoint { int16_t x; uint8_t y; };"
CASES = {
    "a size before and after its array": Case(
        "ER f( [in,size_is(n)] const uint16_t *a, [in] uint8_t k, [in] uint8_t n );",
        {"a": [1, 2], "k": 9, "n": 2},
        "672a 0001 | 02 | 00010002 09 | 5a3c",
    ),
    "sizes of sums and quotients": Case(
        "ER f( [in,size_is(n/2+1)] const int8_t *a, [in] int16_t n );",
        {"a": [-1, -2, -3, -4], "n": 7},
        "672a 0001 | 0007 | fffefdfc | 5a3c",
    ),
    "a constant of the file as a size": Case(
        "ER f( [in,size_is(COUNT)] const int8_t *a );",
        {"a": [1, 2, 3]},
        "672a 0001 010203 5a3c",
        before="const int32_t COUNT = 3;",
    ),
    "a member of a struct as a size": Case(
        "ER f( [in,size_is(p.y)] const int8_t *a, [in] struct tagPoint p );",
        {"a": [5, 6], "p": {"x": -1, "y": 2}},
        "672a 0001 | ffff 02 | 0506 | 5a3c",
        before=POINT,
    ),
    "a size that is an element": Case(
        "ER f( [in,size_is(k[1])] const int8_t *a, [in,size_is(2)] const uint8_t *k );",
        {"a": [7], "k": [9, 1]},
        "672a 0001 | 0901 | 07 | 5a3c",
    ),
    "inout with its size inout": Case(
        "ER f( [inout,size_is(*n)] int16_t *a, [inout] int32_t *n );",
        {"a": [1, 2], "n": 2},
        "672a 0001 | 00000002 | 00010002 | 5a3c",
        "561e 00000000 | 00000001 | 0007 | 6d5e",
        outs={"a": [7], "n": 1},
    ),
    "counted inout whose count alone comes back": Case(
        "ER f( [inout,size_is(8),count_is(*n)] char_t *a, [inout] int8_t *n );",
        {"a": [65, 66], "n": 2},
        "672a 0001 | 02 | 4142 | 5a3c",
        "561e 00000000 | 03 | 616263 | 6d5e",
        outs={"a": [97, 98, 99], "n": 3},
    ),
    "arrays of structs with strings": Case(
        "ER f( [in,size_is(n)] const struct tagName *a, [in] int8_t n );",
        {"a": [{"id": 1, "text": "ab"}, {"id": 2, "text": ""}], "n": 2},
        "672a 0001 | 02 | 01 00000003 616200 | 02 00000001 00 | 5a3c",
        before="struct tagName { int8_t id; [string] char_t *text; };",
    ),
    "a struct whose size comes last": Case(
        "struct tagList f( [in] struct tagList a );",
        {"a": {"kind": 1, "data": [10, 20], "more": [3], "many": 1, "len": 2}},
        "672a 0001 | 01 0002 | 01 | 0000000a00000014 | 03 | 5a3c",
        "561e | 00 0000 | 07 | 6d5e",
        returned={"kind": 7, "data": [], "more": [], "many": 0, "len": 0},
        before="struct tagList { int8_t kind; [size_is(len)] int32_t *data;"
        " [size_is(many)] uint8_t *more; int8_t many; int16_t len; };",
    ),
    "128 bits in a struct whose size depends on values": Case(
        "ER f( [in] struct tagWide a );",
        {"a": {"w": 5, "data": [7], "len": 1}},
        "672a 0001 | 01 | 0000000000000005 0000000000000000 | 07 | 5a3c",
        before="struct tagWide { int128_t w; [size_is(len)] int8_t *data; int8_t len; };",
    ),
    "nested arrays of structs": Case(
        "ER f( [in] const struct tagPoint g[2][2] );",
        {"g": [[{"x": n, "y": n} for n in row] for row in ((1, 2), (3, 4))]},
        "672a 0001 | 000101 000202 000303 000404 | 5a3c",
        before=POINT,
    ),
    "array of pointers to structs": Case(
        "ER f( [inout,size_is(2)] struct tagPoint **g );",
        {"g": [{"x": 1, "y": 2}, {"x": 3, "y": 4}]},
        "672a 0001 | 000102 000304 | 5a3c",
        "561e 00000000 | 000506 000708 | 6d5e",
        outs={"g": [{"x": 5, "y": 6}, {"x": 7, "y": 8}]},
        before=POINT,
    ),
    "a struct through a typedef, with an array": Case(
        "Rows f( [out] Rows *r );",
        {},
        "672a 0001 5a3c",
        "561e | 0001 0002 | 0003 0004 | 6d5e",
        returned={"v": [1, 2]},
        outs={"r": {"v": [3, 4]}},
        before="typedef int16_t pair_t[2]; typedef struct tagRows { pair_t v; } Rows;",
    ),
    "strings of a length given": Case(
        "ER f( [in,string(n)] const char_t *s, [in] int8_t n, [inout,string(4)] char_t *t );",
        {"s": "abc", "n": 4, "t": ""},
        "672a 0001 | 04 | 00000004 61626300 | 00000002 0000 | 5a3c",
        "561e 00000000 | 00000004 78787878 | 6d5e",
        outs={"t": "xxxx"},
    ),
    "strings of 8, 32 and 64-bit units": Case(
        "ER f( [in,string] const int8_t *a, [in,string(3)] const int32_t *b, "
        "[in,string] const uint64_t *c );",
        {"a": "\u00e9", "b": "\u3042", "c": "A"},
        "672a 0001 | 00000002 e900 | 00000003 00003042 00000000 00000000"
        " | 00000002 0000000000000041 0000000000000000 | 5a3c",
    ),
    "lists of strings back": Case(
        "ER f( [out,size_is(2),string(3)] char_t **names );",
        {},
        "672a 0001 5a3c",
        "561e 00000000 | 00000003 610000 | 00000002 0000 | 6d5e",
        outs={"names": ["a", ""]},
    ),
    "all that can be NULL, and is": Case(
        "ER f( [in,nullable] const int32_t *a, [out,nullable,string(4)] char_t *b, "
        "[inout,nullable] int16_t *c, [send(sAlloc),nullable,string] char_t *d, "
        "[receive(sAlloc),nullable] int64_t **e );",
        {"a": None, "b": None, "c": None, "d": None},
        "672a 0001 | 01 | 01 | 01 | 01 | 5a3c",
        "561e 00000000 | 01 | 6d5e",
        outs={"b": None, "c": None, "e": None},
    ),
    "all that can be NULL, and is not": Case(
        "ER f( [in,nullable] const int32_t *a, [out,nullable,string(4)] char_t *b, "
        "[inout,nullable] int16_t *c, [send(sAlloc),nullable,string] char_t *d, "
        "[receive(sAlloc),nullable] int64_t **e );",
        {"a": 1, "b": {"want": True}, "c": 2, "d": "d"},
        "672a 0001 | 00 00000001 | 00 0002 | 00 00000002 6400 | 00 | 5a3c",
        "561e 00000000 | 00000003 620000 | 0003 | 00 0000000000000004 | 6d5e",
        outs={"b": "b", "c": 3, "e": 4},
    ),
    "flags of outs come after all else": Case(
        "ER f( [out,nullable] int8_t *a, [in,size_is(n)] const int8_t *v, [in] int8_t n, "
        "[out,nullable] struct tagPoint *b );",
        {"a": {"want": True}, "v": [5], "n": 1, "b": None},
        "672a 0001 | 01 | 05 | 00 01 | 5a3c",
        "561e 00000000 | 07 | 6d5e",
        outs={"a": 7, "b": None},
        before=POINT,
    ),
    "send and receive": Case(
        "void f( [send(sAlloc),size_is(n)] struct tagPoint *p, [in] int8_t n, "
        "[receive(sAlloc),size_is(*m)] uint8_t **q, [out] int16_t *m );",
        {"p": [{"x": 1, "y": 2}], "n": 1},
        "672a 0001 | 01 | 000102 | 5a3c",
        "561e | 0002 | 0809 | 6d5e",
        returned=None,
        outs={"q": [8, 9], "m": 2},
        before=POINT,
    ),
    "void pointers and 128 bits": Case(
        "int128_t f( [in] const void *p, [in] uint128_t u );",
        {"p": None, "u": 1 << 64},
        "672a 0001 | 0000000000000000 0000000000000001 | 5a3c",
        "561e | fffffffffffffffe ffffffffffffffff | 6d5e",
        returned=-2,
    ),
    "kernel types": Case(
        "ER_UINT f( [in] TMO t, [in] intptr_t p, [in] ulong_t l, [in] bool_t b );",
        {"t": -1, "p": -2, "l": 4000000000, "b": True},
        "672a 0001 | ffffffff | fffffffe | ee6b2800 | 01 | 5a3c",
        "561e ffffffbc 6d5e",
        returned=-68,
    ),
    "oneway with an array": Case(
        "[oneway] ER f( [in,size_is(n)] const float32_t *v, [in] int8_t n );",
        {"v": [1.0], "n": 1},
        "672a 0001 | 01 | 3f800000 | 6d5e",
    ),
    "names that generated code uses itself": Case(
        "ER f( [in] struct Text Text, [in,size_is(len)] const struct tagBox *tagBox, "
        "[in] uint8_t len, [in] int8_t returned, [in] int8_t unpacked );",
        {
            "Text": {"list": 1, "tagBox": {"_int": 2}, "field": {"_int": 3}},
            "tagBox": [{"_int": 4}],
            "len": 1,
            "returned": 5,
            "unpacked": 6,
        },
        "672a 0001 | 01 | 010203 | 04 | 05 06 | 5a3c",
        before="struct tagBox { uint8_t _int; }; struct Text { int8_t list;"
        " struct tagBox tagBox; struct tagBox field; };",
    ),
    "a struct without a byte": Case(
        "ER f( [in] struct tagV v, [in] int8_t k );",
        {"v": {"p": None}, "k": 1},
        "672a 0001 | 01 | 5a3c",
        before="struct tagV { void *p; };",
    ),
    "zero elements": Case(
        "ER f( [in,size_is(n)] const int64_t *v, [in] int8_t n );",
        {"v": [], "n": 0},
        "672a 0001 | 00 | 5a3c",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_bytes(name: str) -> None:
    case = CASES[name]
    function = only(service(case.function, case.before))
    request = bytes.fromhex(case.request.replace("|", ""))
    arguments = function.arguments_from_json(case.args)
    assert function.encode_request(arguments).hex() == request.hex()
    assert function.decode_request(request) == arguments
    if function.oneway:
        return
    reply = bytes.fromhex(case.reply.replace("|", ""))
    result = {"return": case.returned, "outs": case.outs or {}}
    returned, outs = function.result_from_json(result)
    kept = function.kept(arguments)
    assert function.encode_reply(kept, returned, outs).hex() == reply.hex()
    assert function.result_to_json(*function.decode_reply(reply, kept)) == result


def test_paper_order_has_the_outs_first_and_always() -> None:
    text = "ER f( [in] int32_t code, [out] int16_t *o );"
    function = only(service(text, reply="paper"))
    for code in (0, -68):
        reply = b"\x56\x1e\0\x09" + code.to_bytes(4, "big", signed=True) + b"\x6d\x5e"
        assert function.encode_reply((), code, (9,)) == reply
        assert function.decode_reply(reply, ()) == (code, (9,))


@pytest.mark.parametrize(
    ("returns", "is_left_out"),
    [
        ("ER", True),
        ("ER_INT", True),
        ("ER_UINT", False),
        ("ID", False),
        ("int32_t", False),
        ("MY_ER", False),
    ],
)
def test_only_er_by_its_name_leaves_outs_out(returns: str, is_left_out: bool) -> None:
    before = "typedef ER MY_ER; typedef int32_t ER_INT;"
    function = only(service(f"{returns} f( [out] int16_t *o );", before))
    for code in (-68, 188, -4420):
        data = function.encode_reply((), code, (9,))
        assert len(data) == (8 if is_left_out else 10)
        outs = None if is_left_out else (9,)
        assert function.decode_reply(data, ()) == (code, outs)
    assert len(function.encode_reply((), -67, (9,))) == 10


def test_widths_are_those_of_the_peer() -> None:
    text = "long_t f( [in] short_t s, [in] uint_t i, [in] intptr_t p );"
    arguments = (-1, 1, -2)
    function = only(service(text, order="little"))
    hexes = "2a67 0100 ffff 01000000 feffffffffffffff 3c5a"
    assert function.encode_request(arguments) == bytes.fromhex(hexes)
    function = only(service(text, long_bits=64, short_bits=32, int_bits=16))
    hexes = "672a 0001 ffffffff 0001 fffffffe 5a3c"
    assert function.encode_request(arguments) == bytes.fromhex(hexes)
    reply = bytes.fromhex("561e fffffffffffffffb 6d5e")
    assert function.decode_reply(reply, ()) == (-5, ())


@pytest.mark.parametrize(
    ("text", "request_", "code"),
    [
        (
            "ER f( [in,size_is(n,4)] const int8_t *v, [in] int32_t n );",
            "00000005",
            E_PAR,
        ),
        ("ER f( [in,size_is(n)] const int8_t *v, [in] int32_t n );", "ffffffff", E_PAR),
        (
            "ER f( [in,size_is(n)] const int8_t *v, [in] int32_t n );",
            "7fffffff",
            E_NOMEM,
        ),
        (
            "ER f( [in,size_is(9/n)] const int8_t *v, [in] int32_t n );",
            "00000000",
            E_PAR,
        ),
        (
            "ER f( [in,size_is(1<<n)] const int8_t *v, [in] int32_t n );",
            "0fffffff",
            E_PAR,
        ),
        (
            "ER f( [in,size_is(n-1)] const int8_t *v, [in] uint32_t n );",
            "00000000",
            E_PAR,
        ),
        (
            "ER f( [in,size_is(*n)] const int8_t *v, [in,nullable] const int8_t *n );",
            "01",
            E_PAR,
        ),
        (
            "ER f( [in,size_is(k[2])] const int8_t *v, [in] const int8_t k[2] );",
            "0102",
            E_PAR,
        ),
        ("ER f( [in,string(16)] const char_t *s );", "00000011", E_PAR),
        ("ER f( [in,string] const char_t *s );", "7fffffff", E_NOMEM),
        ("ER f( [in,string] const uint64_t *s );", "00000400", E_NOMEM),
        (
            "ER f( [out,size_is(n)] int64_t *v, [in] int32_t n );",
            "00001000 5a3c",
            E_NOMEM,
        ),
        (
            "ER f( [out,size_is(n)] int64_t *v, [in] int32_t n );",
            "80000000 5a3c",
            E_PAR,
        ),
        (
            "ER f( [out,string(n)] char_t *v, [in] int32_t n );",
            "00001001 5a3c",
            E_NOMEM,
        ),
        ("ER f( [in] int32_t n );", "00000001 6d5e", E_MAGIC),
        ("[oneway] void f( [in] int32_t n );", "00000001 5a3c", E_MAGIC),
    ],
)
def test_requests_that_are_refused_before_more_is_read(
    text: str, request_: str, code: int
) -> None:
    function = only(service(text))
    with pytest.raises(ProtocolError) as caught:
        function.decode_request(bytes.fromhex(f"672a0001{request_}"))
    assert caught.value.sub == code


def test_the_end_of_a_request_without_values() -> None:
    function = only(service("ER f( void );"))
    assert function.decode_request(bytes.fromhex("672a0001 5a3c")) == ()
    with pytest.raises(
        ProtocolError, match=r"f: EOP is 6d 5e, expected 5a 3c"
    ) as caught:
        function.decode_request(bytes.fromhex("672a0001 6d5e"))
    assert caught.value.sub == E_MAGIC


@pytest.mark.parametrize(
    ("text", "arguments", "reply", "code"),
    [
        ("ER f( [out,string(n)] char_t *s, [in] int8_t n );", (4,), "00000005", E_PAR),
        (
            "ER f( [out,size_is(n),count_is(*c)] int8_t *v, [in] int8_t n, [inout] int8_t *c );",
            (2, 1),
            "03",
            E_PAR,
        ),
        (
            "ER f( [inout,size_is(*n)] int8_t *v, [inout] int8_t *n );",
            (b"a", 1),
            "02",
            E_PAR,
        ),
        (
            "ER f( [receive(sAlloc),size_is(*n)] int8_t **v, [out] int32_t *n );",
            (),
            "7fffffff",
            E_NOMEM,
        ),
        (
            "ER f( [receive(sAlloc),size_is(*n)] int8_t **v, [out] int32_t *n );",
            (),
            "80000000",
            E_PAR,
        ),
    ],
)
def test_replies_with_more_than_the_caller_holds_are_refused(
    text: str, arguments: tuple[object, ...], reply: str, code: int
) -> None:
    function = only(service(text))
    data = bytes.fromhex(f"561e00000000{reply}")
    with pytest.raises(ProtocolError) as caught:
        function.decode_reply(data, function.kept(arguments))
    assert caught.value.sub == code


@pytest.mark.parametrize(
    ("text", "args"),
    [
        ("ER f( [in,size_is(n)] const int8_t *v, [in] int8_t n );", {"v": [1], "n": 2}),
        (
            "ER f( [in,size_is(n,1)] const int8_t *v, [in] int8_t n );",
            {"v": [1, 2], "n": 2},
        ),
        ("ER f( [in,string(2)] const char_t *s );", {"s": "abc"}),
        ("ER f( [in] const int8_t v[2] );", {"v": [1]}),
        ("ER f( [in] const uint8_t v[2] );", {"v": [1, 2, 3]}),
        ("ER f( [in] int8_t v );", {"v": 256}),
        ("ER f( [in] uint128_t v );", {"v": -1}),
        (
            "ER f( [in,size_is(9/n)] const int8_t *v, [in] int8_t n );",
            {"v": [], "n": 0},
        ),
    ],
)
def test_values_that_do_not_fit_are_refused(text: str, args: dict[str, Any]) -> None:
    function = only(service(text))
    with pytest.raises(ArgumentError, match=r"^sOne\.f\("):
        function.encode_request(function.arguments_from_json(args))


@pytest.mark.parametrize(
    ("text", "arguments"),
    [
        ("ER f( [in,string(16)] const char_t *s );", (5,)),
        ("ER f( [in] const int32_t v[2] );", (None,)),
        ("ER f( [in] int32_t v );", ("1",)),
    ],
)
def test_values_of_wrong_types_are_refused(
    text: str, arguments: tuple[Any, ...]
) -> None:
    function = only(service(text))
    with pytest.raises(ArgumentError, match=r"^sOne\.f\("):
        function.encode_request(arguments)


def test_a_client_holds_16_mib_unless_told_otherwise() -> None:
    declared = "ER f( [receive(sAlloc),size_is(*n)] int8_t **v, [out] uint32_t *n );"
    function = only(service(declared))
    for size, code in ((1 << 24, E_BOVR), ((1 << 24) + 1, E_NOMEM)):
        with pytest.raises(RpcError) as caught:
            function.decode_reply(bytes.fromhex(f"561e00000000{size:08x}"), ())
        assert caught.value.sub == code


def test_a_zero_flag_alone_is_present_and_any_truth_value_true() -> None:
    function = only(service("ER f( [in,nullable] const bool_t *p );"))
    read = {"00 02": (True,), "00 00": (False,), "07": (None,), "ff": (None,)}
    for data, arguments in read.items():
        request = bytes.fromhex(f"672a0001 {data} 5a3c")
        assert function.decode_request(request) == arguments


@pytest.mark.parametrize(
    ("size", "n", "count"),
    [
        ("n > 2 ? 2 : n", 5, 2),
        ("n > 2 ? 2 : n", 1, 1),
        ("(uint8_t)n", 258, 2),
        ("(n + 7) / 8 * 2", 9, 4),
        ("-n / 2", -7, 3),
        ("n % 4 + 4", -7, 1),
        ("n << 2", 1, 4),
        ("n >> 1", 7, 3),
        ("~n & 3", 1, 2),
        ("n ^ 1 | 4", 1, 4),
        ("(n == 3 ? 1 : 0) + (n != 3 || n >= 9 ? 5 : 2)", 3, 3),
        ("!(n > 1 && n > 2) ? n : 0", 2, 2),
        ("+n - (-1)", 2, 3),
    ],
)
def test_sizes_are_worked_out_as_in_c(size: str, n: int, count: int) -> None:
    text = f"ER f( [in,size_is({size})] const int8_t *v, [in] int16_t n );"
    function = only(service(text))
    arguments = ([1] * count, n)
    request = function.encode_request(arguments)
    assert len(request) == 8 + count
    assert function.decode_request(request) == arguments


def refusals(function: str, before: str = "") -> list[TransferError]:
    unit, _ = read_text(f"{ALLOCATOR}{before}\nsignature sOne {{ {function} }};")
    signature = next(
        d for d in unit.declarations if isinstance(d, Signature) and d.name == ("sOne",)
    )
    return list(problems(unit, signature))


@pytest.mark.parametrize(
    ("function", "before", "reason"),
    [
        ("ER f( [in] enum eKind k );", "enum eKind { A };", "enum eKind"),
        ("ER f( [in] struct tagA a );", "struct tagA { struct tagA *a; };", "itself"),
        ("ER f( [out,string] char_t *s );", "", "needs a length"),
        ("ER f( [in,string] const int_t *s );", "", "a string of"),
        (
            "ER f( [in,size_is(n)] const struct tagV *v, [in] int32_t n );",
            "struct tagV { void *p; };",
            "no byte",
        ),
        ("ER f( [in] struct tagV v );", "struct tagV { void *p[2]; };", "no byte"),
        (
            "ER f( [in,size_is(a[0])] const int8_t *v, [in,size_is(v[0])] const int8_t *a );",
            "",
            "depends on",
        ),
    ],
)
def test_what_cannot_be_transferred_is_reported(
    function: str, before: str, reason: str
) -> None:
    (found,) = refusals(function, before)
    assert reason in found.reason
    assert found.span.line > 1


def test_rpc_errors_of_cut_replies_have_the_code_of_c_clients() -> None:
    function = only(service("ER f( [in] int32_t v );"))
    with pytest.raises(RpcError) as caught:
        function.decode_reply(bytes.fromhex("561e0000"), ())
    assert caught.value.code == -14660
    with pytest.raises(RpcError) as caught:
        function.decode_reply(bytes.fromhex("000000000000 6d5e"), ())
    assert caught.value.code == -25924
