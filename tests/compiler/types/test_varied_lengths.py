"""Texts and sequences whose lengths vary: the same octets as from the descriptors."""

from decimal import Decimal
from itertools import product
from typing import Any

import emitted
import pytest

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.dynamic.values import encoded
from rtgen.runtime.marshalling.layouts.shapes import SHAPES_KEPT

IDL = """
module v {
    typedef sequence<octet> Octets;
    typedef sequence<short> Shorts;
    typedef sequence<double> Doubles;
    typedef sequence<wchar> Letters;
    typedef sequence<fixed<9, 2> > Prices;
    struct Mark { long id; octet level; };
    typedef sequence<Mark> Marks;
    struct Classic {
        sequence<Letters> letter_rows; octet after_letters;
        sequence<Prices> price_rows; octet after_prices;
        sequence<Marks> mark_rows; octet after_marks;
    };
    struct Pair { string key; string value; };
    struct Tagged { boolean good; long id; wstring name; string unit; octet last; };
    struct Numbered { long id; string name; };
    struct Ended { string name; octet end; };
    struct Weighted { string name; double weight; };
    struct Kinds { Octets raw; string name; };
    struct Everything {
        octet before;
        sequence<Pair> pairs; octet after_pairs;
        sequence<Numbered> n_items; octet after_numbered;
        sequence<Ended> e_items;
        sequence<Weighted> w_items;
        sequence<Kinds> k_items; octet after_kinds;
        sequence<string> names; octet after_names;
        sequence<string<50> > bounded; octet after_bounded;
        sequence<wstring> wide; octet after_wide;
        sequence<Octets> o_items; octet after_octets;
        sequence<Shorts> s_items; octet after_shorts;
        sequence<Doubles> d_items;
    };
};
"""


@pytest.fixture(scope="module")
def types(tmp_path_factory: pytest.TempPathFactory) -> Any:
    folder = tmp_path_factory.mktemp("varied")
    path = folder / "v.idl"
    path.write_text(IDL, encoding="utf-8")
    return emitted.emit(folder, [path]).v


def text(length: int) -> str:
    return ("é" if length % 5 == 3 else "x") * length


def everything(types: Any, lengths: range) -> Any:
    texts = [text(n) for n in lengths]
    return types.Everything(
        1,
        [types.Pair(a, b) for a, b in zip(texts, texts[::-1], strict=True)],
        2,
        [types.Numbered(n, a) for n, a in enumerate(texts)],
        3,
        [types.Ended(a, 7) for a in texts],
        [types.Weighted(a, n / 7) for n, a in enumerate(texts)],
        [types.Kinds(a.encode(), a) for a in texts],
        4,
        texts,
        5,
        [a[:25] for a in texts],
        6,
        texts,
        7,
        [a.encode() for a in texts],
        8,
        [[*range(n)] for n in lengths],
        9,
        [[i / 3 for i in range(n)] for n in lengths],
    )


def check(value: Any) -> None:
    for little_endian in (True, False):
        octets = value.to_cdr(little_endian)
        assert octets == encoded(value._descriptor_, value, little_endian)
        assert type(value).from_cdr(octets, little_endian) == value
        for way in ("xcdr1", "xcdr2"):
            octets = getattr(value, f"to_{way}")(little_endian)
            decode = getattr(type(value), f"from_{way}")
            assert decode(octets, little_endian) == value


@pytest.mark.parametrize("number", range(6))
def test_sequences_of_any_number_and_lengths(types: Any, number: int) -> None:
    for start in range(9):
        check(everything(types, range(start, start + number)))


@pytest.mark.parametrize("counts", [(), (1,), (0, 2), (2, 1, 3), (4, 5), (1, 0)])
@pytest.mark.parametrize("little_endian", [True, False])
def test_rows_of_items_of_odd_sizes(
    types: Any, counts: tuple[int, ...], little_endian: bool
) -> None:
    value = types.Classic(
        [["a"] * n for n in counts],
        1,
        [[Decimal("1.00")] * n for n in counts],
        2,
        [[types.Mark(i, 7) for i in range(n)] for n in counts],
        3,
    )
    octets = value.to_cdr(little_endian)
    assert octets == encoded(value._descriptor_, value, little_endian)
    assert types.Classic.from_cdr(octets, little_endian) == value


def test_more_shapes_than_are_kept(types: Any) -> None:
    lengths = product(range(25), range(25))
    values = [types.Pair(text(a), text(b)) for a, b in lengths]
    assert len(values) > SHAPES_KEPT
    for value in values:
        check(value)
        check(types.Tagged(True, 5, value.key, value.value, 9))


def test_more_lengths_than_are_kept(types: Any) -> None:
    check(everything(types, range(0, SHAPES_KEPT + 100, 2)))


@pytest.mark.parametrize("end", range(1, 40))
def test_a_cut_body_is_refused(types: Any, end: int) -> None:
    octets = everything(types, range(3)).to_cdr()
    with pytest.raises(CdrError):
        types.Everything.from_cdr(octets[: end * len(octets) // 40])


@pytest.mark.parametrize("value", ["a\0b", 5, b"x", "\ud800"])
def test_a_wrong_text_is_located(types: Any, value: object) -> None:
    wrong = everything(types, range(4))
    wrong.pairs[2].value = value
    with pytest.raises(CdrError, match=r"^Everything\.pairs\[2\]\.value: "):
        wrong.to_cdr()
    with pytest.raises(CdrError, match=r"^Pair\.value: "):
        wrong.pairs[2].to_cdr()
