"""Numbers as lists, arrays and numpy arrays: the same octets, equal values, located faults."""

from __future__ import annotations

import copy
import ctypes
import json
import pickle
from array import array
from pathlib import Path
from types import ModuleType
from typing import Any

import emitted
import msgspec
import numpy
import pytest

from rtgen.cli import run
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.lowering.numeric import lower
from rtgen.compiler.lowering.settings import Settings
from rtgen.facts.numeric import FORMS, MAX_LIST_LENGTH, Numeric
from rtgen.runtime import idl
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.numeric import NumericArray
from rtgen.runtime.system.json_printers import json_printer
from rtgen.runtime.values import AnyValue

IDL = """
module n {
    typedef sequence<double> Doubles;
    struct Point { double x; float y; float class; octet rgb[8]; };
    struct Wide { Point a; double m[2]; };
    struct Gap { double x; short last; };
    struct Pose { double at[3]; Gap between; float turn[2][2]; octet state; };
    struct Uneven { long first; double x; };
    struct Everything {
        octet shift;
        sequence<double> scan;
        sequence<short> image;
        sequence<unsigned long long, 100> counters;
        sequence<long, 4> few;
        Doubles named;
        float matrix[2][3];
        float row[20];
        float long_row[80];
        long triple[3];
        sequence<Point> cloud;
        sequence<Wide> wides;
        sequence<Gap> gaps;
        Gap fixed_gaps[3];
        octet after;
        sequence<Pose> poses;
        sequence<Uneven> unevens;
        sequence<Doubles> rows;
        string end;
    };
    struct Flags { sequence<boolean> several; boolean three[3]; float matrix[2][3]; };
    union Choice switch (long) { case 1: sequence<float> numbers; case 2: sequence<Point> points; };
    exception Failed { sequence<long long> codes; };
    struct Held { Everything inner; any thing; };
    struct Numbered { long number; float row[80]; };
    struct Longs { sequence<Numbered> rows; };
    struct Followed {
        sequence<double> scan; octet rgb[3]; long after; sequence<long> ids; short last;
    };
};
"""
MATRIX = [[0.5, 1.5, 2.5], [3.5, 4.5, 5.5]]
WAYS = ("cdr", "xcdr1", "xcdr2")


@pytest.fixture(scope="module")
def numpies(packages: dict[Numeric, Any]) -> Any:
    return packages["numpy"]


def filled(n: ModuleType, count: int) -> Any:
    """Return a value with that many numbers in each sequence, all of them lists."""
    points = [n.Point(i / 7, i / 4, -i, bytes([i % 256] * 8)) for i in range(count)]
    return n.Everything(
        shift=3,
        scan=[i / 3 for i in range(count)],
        image=[i - 5 for i in range(count)],
        counters=[(1 << 64) - 1 - i for i in range(min(count, 100))],
        few=[-1, 0, 1][:count],
        named=[-0.0] * count,
        matrix=MATRIX,
        row=[i / 2 for i in range(20)],
        long_row=[i / 2 for i in range(80)],
        triple=[-1, 2, 3],
        cloud=points,
        wides=[n.Wide(point, [1.0, point.x]) for point in points],
        gaps=[n.Gap(1.0, i % 9) for i in range(count)],
        fixed_gaps=[n.Gap(0.5, i) for i in range(3)],
        after=255,
        poses=[
            n.Pose([i, 0.5, -0.5], n.Gap(i, 1), [[1.0, 2.0], [3.0, 4.0]], i % 256)
            for i in range(count)
        ],
        unevens=[n.Uneven(i, i / 2) for i in range(count)],
        rows=[[float(i)] * (i % 3) for i in range(min(count, 9))],
        end="é" * (count % 5),
    )


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("count", [0, MAX_LIST_LENGTH, MAX_LIST_LENGTH + 1])
def test_members_after_numbers(
    packages: dict[Numeric, Any], form: Numeric, count: int
) -> None:
    type_ = packages[form].Followed
    value = type_([0.5] * count, b"rgb", -7, list(range(count)), 9)
    again = type_.from_cdr(value.to_cdr())
    assert (again.rgb, again.after, again.last) == (b"rgb", -7, 9)
    assert ([*again.scan], [*again.ids]) == ([0.5] * count, [*range(count)])


def test_long_arrays_in_elements(packages: dict[Numeric, Any]) -> None:
    for form, kind in (("list", list), ("array", NumericArray)):
        n = packages[form]
        value = n.Longs([n.Numbered(i, [i / 2] * 80) for i in range(3)])
        again = n.Longs.from_cdr(value.to_cdr())
        assert again == value
        assert {type(element.row) for element in again.rows} == {kind}


def test_types_settle_the_form(packages: dict[Numeric, Any]) -> None:
    lists, arrays, numpies = (packages[form].Everything() for form in FORMS)
    assert type(lists.scan) is type(lists.long_row) is type(arrays.scan) is list
    for count, form in ((MAX_LIST_LENGTH, list), (MAX_LIST_LENGTH + 1, NumericArray)):
        made = filled(packages["array"], count)
        made = packages["array"].Everything.from_cdr(made.to_cdr())
        assert type(made.scan) is type(made.counters) is type(made.named) is form
        assert type(made.few) is type(made.triple) is type(made.matrix) is list
        assert type(made.cloud) is type(made.row) is list
        assert type(made.long_row) is NumericArray
    assert made.scan.typecode == "d"
    assert made.counters.typecode == "Q"
    assert made.long_row.typecode == "f"
    assert numpies.scan.dtype == numpy.float64
    assert numpies.matrix.shape == (2, 3)
    assert numpies.cloud.dtype == idl.dtype(packages["numpy"].Point)
    assert numpies.cloud.dtype.names == ("x", "y", "class", "rgb")
    assert numpies.gaps.dtype.itemsize == 16
    assert numpies.poses.dtype == idl.dtype(packages["numpy"].Pose)
    assert numpies.poses.dtype["at"].shape == (3,)
    assert type(numpies.unevens) is list


@pytest.mark.sampled(3)
@pytest.mark.parametrize("count", [0, 1, 3, 200, 3000])
@pytest.mark.parametrize("little", [True, False])
def test_octets_are_those_of_lists(
    packages: dict[Numeric, Any], count: int, little: bool
) -> None:
    wanted = filled(packages["list"], count)
    for way in WAYS:
        octets = getattr(wanted, f"to_{way}")(little)
        for form in FORMS:
            type_ = packages[form].Everything
            given = filled(packages[form], count)
            assert getattr(given, f"to_{way}")(little) == octets
            made = getattr(type_, f"from_{way}")(octets, little)
            assert getattr(made, f"to_{way}")(little) == octets
            shifted = memoryview(b"." + octets)[1:]
            assert getattr(type_, f"from_{way}")(shifted, little) == made
            copied = made._snapshot_()
            assert copied == made
            assert copied.scan is not made.scan
            assert getattr(copied, f"to_{way}")(little) == octets


def test_arrays_are_equal_to_lists(arrays: Any) -> None:
    value = filled(arrays, 100)
    made = arrays.Everything.from_cdr(value.to_cdr())
    assert made == value
    assert value == made
    assert made.scan == value.scan
    assert value.scan == made.scan
    assert made.scan == tuple(value.scan)
    assert made.scan != [*value.scan[:99], 9.0]
    assert made.scan != value.scan[:4]
    assert made.scan != "text"
    made.scan += [1.0]
    assert made != value
    with pytest.raises(TypeError, match="unhashable"):
        hash(made.scan)


def test_copies_and_pickles(packages: dict[Numeric, Any]) -> None:
    for form in FORMS:
        made = packages[form].Everything.from_cdr(filled(packages[form], 100).to_cdr())
        for other in (
            copy.deepcopy(made),
            pickle.loads(pickle.dumps(made)),
            made._snapshot_(),
        ):
            assert other == made
            assert type(other.scan) is type(made.scan)
            other.scan[3] = 77.0
            assert other != made
            assert made.scan[3] == 1.0
        assert copy.copy(made.scan)[3] == 1.0
        assert "scan=" in repr(made)


def test_equality_of_numpy_members(numpies: Any) -> None:
    one = numpies.Choice.of_points(numpy.zeros(2, idl.dtype(numpies.Point)))
    other = numpies.Choice.from_cdr(one.to_cdr())
    assert one == other
    other.value["x"][1] = 1.0
    assert one != other
    assert one != 5
    assert numpies.Failed(numpy.arange(3)) == numpies.Failed(numpy.arange(3))
    assert numpies.Failed(numpy.arange(3)) != numpies.Failed(numpy.arange(4))


def test_logs_print_each_form_alike(packages: dict[Numeric, Any]) -> None:
    texts = set()
    for form in FORMS:
        type_ = packages[form].Everything
        made = type_.from_cdr(filled(packages[form], 6).to_cdr())
        texts.add(json_printer(type_)(made))
    (text,) = texts
    assert json.loads(text)["cloud"][2]["class"] == -2.0


def test_any_and_dynamic_values(packages: dict[Numeric, Any]) -> None:
    wanted = None
    for form in FORMS:
        n = packages[form]
        inner = n.Everything.from_cdr(filled(n, 20).to_cdr())
        held = n.Held(inner, AnyValue(n.DoublesCodec, inner.named))
        octets = held.to_cdr(False)
        assert wanted in (None, octets)
        wanted = octets
        made = n.Held.from_cdr(octets, False)
        assert made.inner == inner
        assert list(made.thing.value) == [0.0] * 20
        assert copy.deepcopy(made).to_cdr(False) == octets
        # Of the three types with one repository id, one is found by it.
        structs = AnyValue(n.Everything, inner).to_cdr()
        assert AnyValue.from_cdr(structs).to_cdr() == structs


@pytest.mark.sampled(14)
@pytest.mark.parametrize(
    ("scan", "numbers"),
    [
        (array("d", [1, 2]), [1, 2]),
        (numpy.arange(6.0)[::2], [0, 2, 4]),
        (numpy.arange(3, dtype=">f8"), [0, 1, 2]),
        (memoryview(array("d", [3])), [3]),
        (memoryview(numpy.arange(3, dtype=">f8")), [0, 1, 2]),
        ((ctypes.c_double * 2)(1, 2), [1, 2]),
        ((ctypes.c_double.__ctype_be__ * 2)(1, 2), [1, 2]),
        ((1.0, 2), [1, 2]),
        (range(3), [0, 1, 2]),
        (numpy.zeros(0), []),
        (numpy.arange(4998.0)[::2], [*range(0, 4998, 2)]),
        (numpy.arange(5000.0)[::2], [*range(0, 5000, 2)]),
        (numpy.arange(2500.0, dtype=">f8")[::-1], [*range(2499, -1, -1)]),
        (numpy.arange(2500.0, dtype="<f8")[::-1], [*range(2499, -1, -1)]),
    ],
)
@pytest.mark.parametrize("form", FORMS)
def test_encoding_takes_any_fitting_buffer(
    packages: dict[Numeric, Any], form: Numeric, scan: Any, numbers: list[float]
) -> None:
    for little in (True, False):
        value = packages[form].Everything(scan=scan)
        for way in WAYS:
            octets = getattr(value, f"to_{way}")(little)
            made = getattr(packages[form].Everything, f"from_{way}")(octets, little)
            assert list(made.scan) == numbers
        n = packages[form]
        held = n.Held(thing=AnyValue(n.DoublesCodec, scan)).to_cdr(little)
        assert [*n.Held.from_cdr(held, little).thing.value] == numbers
        assert [*value._snapshot_().scan] == numbers
        assert json.loads(json_printer(n.Everything)(value))["scan"] == numbers


@pytest.mark.parametrize(
    "rows",
    [
        numpy.array(MATRIX, "f"),
        numpy.array(MATRIX, ">f4"),
        numpy.asfortranarray(MATRIX, "f"),
        memoryview(numpy.array(MATRIX, "f")),
        memoryview(numpy.array(MATRIX, ">f4")),
        (ctypes.c_float * 3 * 2)(*(tuple(row) for row in MATRIX)),
        [array("f", row) for row in MATRIX],
        [numpy.array(row, "f") for row in MATRIX],
        tuple(map(tuple, MATRIX)),
    ],
)
@pytest.mark.parametrize("form", FORMS)
def test_arrays_of_several_dimensions_take_buffers(
    packages: dict[Numeric, Any], form: Numeric, rows: Any
) -> None:
    n = packages[form]
    for little in (True, False):
        wanted = n.Flags(matrix=MATRIX).to_cdr(little)
        value = n.Flags(matrix=rows)
        assert value.to_cdr(little) == wanted
        assert value._snapshot_().to_cdr(little) == wanted
        assert json.loads(json_printer(n.Flags)(value))["matrix"] == MATRIX


@pytest.mark.parametrize("form", FORMS)
def test_booleans_take_buffers_of_booleans(
    packages: dict[Numeric, Any], form: Numeric
) -> None:
    n = packages[form]
    flags = numpy.array([True, False, True])
    for given in (flags, memoryview(flags), (ctypes.c_bool * 3)(*flags), (1, 0, 1)):
        value = n.Flags(several=given, three=given)
        made = n.Flags.from_cdr(value.to_cdr())
        assert made.several == made.three == [True, False, True]
        assert value._snapshot_().to_cdr() == value.to_cdr()


def test_copies_of_lists_hold_plain_numbers(packages: dict[Numeric, Any]) -> None:
    value = packages["list"].Everything(
        scan=numpy.arange(2.0), counters=numpy.arange(2, dtype="u8")
    )
    copied = value._snapshot_()
    assert {type(item) for item in copied.scan} == {float}
    assert {type(item) for item in copied.counters} == {int}


class Miscounted(list[float]):
    """A list whose length is wrong."""

    def __len__(self) -> int:
        return 5


ZEROS = numpy.zeros
FAULTS: list[tuple[str, Any, str]] = [
    ("scan", array("f", [1]), ".scan: a buffer of float of 64 bits"),
    ("scan", ZEROS(3, numpy.int64), ".scan: a buffer of float of 64 bits"),
    ("scan", ZEROS((3, 3)), ".scan: a buffer of 1 dimension is needed, not of 2"),
    ("scan", ZEROS((0, 3)), ".scan: a buffer of 1 dimension"),
    ("scan", numpy.float64(3), ".scan: a buffer of 1 dimension"),
    ("scan", b"ab", ".scan: a buffer of float"),
    ("scan", "ab", ".scan: a list is needed, not str"),
    ("scan", None, ".scan: a list is needed, not NoneType"),
    ("scan", {1.0: 2.0}, ".scan: a list is needed, not dict"),
    ("scan", {1.0}, ".scan: a list is needed, not set"),
    ("scan", memoryview(bytes(48)).cast("d", (2, 3)), ".scan: a buffer of 1 dimension"),
    ("scan", numpy.ma.zeros(3), ".scan: a masked array is not marshalled"),
    ("scan", numpy.array([1.0], object), ".scan: a buffer of float of 64 bits"),
    ("scan", Miscounted([1.0]), ".scan: 1 items, and its length is 5"),
    ("scan", [1.0, "x"], ".scan[1]: a value of double is needed, not 'x'"),
    ("scan", (1.0, None), ".scan[1]: a value of double is needed"),
    ("image", ZEROS(3, numpy.uint16), ".image: a buffer of int of 16 bits"),
    ("image", [70000], ".image[0]: 70000 is out of the range of short"),
    (
        "counters",
        ZEROS(101, numpy.uint64),
        ".counters: 101 items, and 100 are the most",
    ),
    ("counters", [0] * 101, ".counters: 101 items, and 100 are the most"),
    ("row", [1.0], ".row: 1 items instead of 20"),
    ("long_row", [1.0], ".long_row: 1 items instead of 80"),
    ("long_row", array("d", [0.0] * 80), ".long_row: a buffer of float of 32 bits"),
    ("long_row", array("f", [0.0] * 79), ".long_row: 79 items instead of 80"),
    ("long_row", (ctypes.c_float * 79)(), ".long_row: 79 items instead of 80"),
    ("matrix", ZEROS((2, 3)), ".matrix: a buffer of float of 32 bits"),
    ("matrix", ZEROS((3, 2), "f"), ".matrix: the shape (3, 2) instead of (2, 3)"),
    ("matrix", memoryview(ZEROS((3, 2), "f")), ".matrix: the shape (3, 2) instead"),
    ("matrix", [[0] * 3, ZEROS(3)], ".matrix[1]: a buffer of float of 32 bits"),
    ("rows", memoryview(bytes(48)).cast("d", (2, 3)), ".rows: multi-dimensional"),
    ("cloud", memoryview(bytes(6)).cast("B", (2, 3)), ".cloud: multi-dimensional"),
    ("rows", [[1.0], [2.0, "x"]], ".rows[1][1]: a value of double is needed"),
    ("rows", [[1.0], array("i", [1])], ".rows[1]: a buffer of float of 64 bits"),
]
OF_NUMPY: list[tuple[str, Any, str]] = [
    ("matrix", ZEROS((3, 2), "f"), ".matrix: the shape (3, 2) instead of (2, 3)"),
    ("matrix", ZEROS(6, "f"), ".matrix: the shape (6,) instead of (2, 3)"),
    ("matrix", ZEROS((2, 3)), ".matrix: a buffer of float of 32 bits"),
    ("matrix", [[1.0, 2.0, 3.0]], ".matrix: 1 items instead of 2"),
    ("cloud", ZEROS(3), ".cloud: records of "),
    ("cloud", ZEROS(3, [("x", "f8")]), ".cloud: records of "),
    ("cloud", [1], ".cloud[0]: a value of n::Point is needed, not int"),
    ("cloud", (1,), ".cloud: an array of records is needed, not tuple"),
]


@pytest.mark.parametrize("form", ["list", "array"])
@pytest.mark.parametrize("way", ["cdr", "xcdr2"])
@pytest.mark.parametrize(("member", "wrong", "message"), FAULTS)
def test_faults_have_the_path_of_the_member(
    packages: dict[Numeric, Any],
    form: Numeric,
    way: str,
    member: str,
    wrong: Any,
    message: str,
) -> None:
    value = filled(packages[form], 2)
    setattr(value, member, wrong)
    with pytest.raises(CdrError) as caught:
        getattr(value, f"to_{way}")()
    assert str(caught.value).startswith("Everything" + message)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (ZEROS(3), "a buffer of bool of 8 bits"),
        (ZEROS(3, "c16"), "a buffer of bool of 8 bits"),
        (ZEROS(3, "u1"), "a buffer of bool of 8 bits"),
        (memoryview(bytes(6)).cast("?", (2, 3)), "a buffer of 1 dimension"),
        ({True}, "a list is needed, not set"),
    ],
)
@pytest.mark.parametrize("member", ["several", "three"])
def test_faults_of_booleans(arrays: Any, member: str, wrong: Any, message: str) -> None:
    with pytest.raises(CdrError, match=rf"Flags\.{member}: {message}"):
        arrays.Flags(**{member: wrong}).to_cdr()


@pytest.mark.parametrize(("member", "wrong", "message"), FAULTS[:14] + OF_NUMPY)
def test_faults_of_numpy_members(
    numpies: Any, member: str, wrong: Any, message: str
) -> None:
    value = filled(numpies, 2)
    setattr(value, member, wrong)
    with pytest.raises(CdrError) as caught:
        value.to_cdr()
    assert str(caught.value).startswith("Everything" + message)


@pytest.mark.sampled(0)
@pytest.mark.parametrize("form", ["array", "numpy"])
def test_octets_that_end_early_are_refused(
    packages: dict[Numeric, Any], form: Numeric
) -> None:
    type_ = packages[form].Everything
    for way in WAYS:
        octets = getattr(filled(packages["list"], 3), f"to_{way}")()
        for end in range(len(octets)):
            with pytest.raises(CdrError):
                getattr(type_, f"from_{way}")(octets[:end])
    huge = b"\0\0\0\0" + b"\xff" * 12
    with pytest.raises(CdrError, match=r"Everything\.scan: a length of"):
        type_.from_cdr(huge)


def test_structs_of_many_numbers(tmp_path: Path) -> None:
    """Python limits the targets before a starred one; large structs have functions of their own."""
    numbers = " ".join(f"double x{i};" for i in range(300))
    text = f"""struct Many {{ {numbers} short rows[2][2]; octet k; }};
        struct S {{ sequence<Many> records; }};"""
    packages: list[Any] = []
    for form in FORMS:
        (tmp_path / form).mkdir()
        packages.append(emitted.emit_text(tmp_path / form, text, form))
    values = [0.5 * i for i in range(300)]
    many = packages[0].Many(*values, [[1, 2], [3, 4]], 5)
    sent = packages[0].S([many] * 2)
    for way in WAYS:
        octets = getattr(sent, f"to_{way}")()
        for package in packages:
            made = getattr(package.S, f"from_{way}")(octets)
            assert getattr(made, f"to_{way}")() == octets
    assert made.records["x299"].tolist() == [149.5, 149.5]
    assert made.records.dtype == idl.dtype(package.Many)


def test_padding_of_records_is_zero(tmp_path: Path) -> None:
    text = (
        "struct P { double a; octet b; double c; }; struct S { sequence<P> records; };"
    )
    package: Any = emitted.emit_text(tmp_path, text, "numpy")
    dtype = idl.dtype(package.P)
    assert dtype.itemsize == 24
    records = numpy.frombuffer(b"\xff" * 48, dtype)
    octets = package.S(records).to_cdr()
    assert octets[4 + 4 + 8 + 1 : 4 + 4 + 16] == bytes(7)
    assert package.S.from_cdr(octets).to_cdr() == octets
    with pytest.raises(TypeError):
        idl.dtype(package.S)


def test_values_as_data(arrays: Any) -> None:
    value = arrays.Everything.from_cdr(filled(arrays, 100).to_cdr())
    data = msgspec.to_builtins(value, builtin_types=(bytes,), enc_hook=list)
    assert data["scan"][:2] == [0.0, 1 / 3]
    assert msgspec.convert(data, arrays.Everything) == value


PROJECT = """
[sources]
paths = ["a.idl"]
[output]
package = "p"
[python]
numeric = "{}"
"""


def test_the_project_file_chooses(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    text = """struct S { sequence<long> a; @numeric("list") sequence<long> b;
        @numeric(NUMPY) sequence<long> c; };"""
    (tmp_path / "a.idl").write_text(text, encoding="utf-8")
    annotations = {
        "list": "list[int]",
        "array": "MutableSequence[int]",
        "numpy": "NDArray[numpy.int32]",
    }
    for form, annotation in annotations.items():
        (tmp_path / "rtgen.toml").write_text(PROJECT.format(form), encoding="utf-8")
        assert run(["generate"]) == 0
        made = Path("generated/p/_idl/a.py").read_text(encoding="utf-8")
        assert f"    a: {annotation} = field(" in made
        assert "    b: list[int] = field(" in made
        assert "    c: NDArray[numpy.int32] = field(" in made
    (tmp_path / "rtgen.toml").write_text(PROJECT.format("tuple"), encoding="utf-8")
    assert run(["generate"]) == 2


@pytest.mark.parametrize(
    ("member", "code"),
    [
        ('@numeric("tuple") sequence<long> a', "IDL0802"),
        ("@numeric sequence<long> a", "IDL0802"),
        ('@numeric("array") long a', "NUM0001"),
        ('@numeric("array") string a', "NUM0001"),
        ('@numeric("numpy") sequence<boolean> a', "NUM0001"),
        ('@numeric("numpy") sequence<octet> a', "NUM0001"),
        ('@numeric("array") double a[2][2]', "NUM0001"),
        ('@numeric("array") sequence<P> a', "NUM0001"),
        ('@numeric("numpy") sequence<Q> a', "NUM0001"),
        ('@numeric("numpy") sequence<R> a', "NUM0001"),
        ('@numeric("numpy") sequence<T> a', "NUM0001"),
        ('@numeric("numpy") sequence<U> a', ""),
        ('@numeric("numpy") sequence<P> a', ""),
        ('@numeric("numpy") double a[2][2]', ""),
        ('@numeric("array") double a[2]', ""),
    ],
)
def test_what_numeric_belongs_to(tmp_path: Path, member: str, code: str) -> None:
    file = tmp_path / "a.idl"
    text = f"""struct P {{ double x; }}; struct Q {{ string s; }};
        struct R {{ octet table[2][2]; }}; struct T {{ long i; double x; }};
        struct U {{ double x; long i; }}; struct S {{ {member}; }};"""
    file.write_text(text, encoding="utf-8")
    result = load([file], root=tmp_path)
    found = [d.code for d in result.diagnostics]
    if not found:
        found = [d.code for d in lower(result.model, Settings()).diagnostics]
    assert found == ([code] if code else [])
