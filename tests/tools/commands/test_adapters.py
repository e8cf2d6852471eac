"""Adapters: copied members, compatible numbers, and the component's behaviour."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from math import pi, tau
from pathlib import Path
from typing import Any

import numpy
import pytest
from adapter_peer import connected
from type_checkers import check_by_mypy

from rtgen.cli import run
from rtgen.compiler.project.output import component_types
from rtgen.runtime import Component
from rtgen.runtime.marshalling.numeric import NumericArray

INTEGERS = {
    "int8": (-(2**7), 2**7 - 1),
    "uint8": (0, 2**8 - 1),
    "octet": (0, 2**8 - 1),
    "short": (-(2**15), 2**15 - 1),
    "unsigned short": (0, 2**16 - 1),
    "long": (-(2**31), 2**31 - 1),
    "unsigned long": (0, 2**32 - 1),
    "long long": (-(2**63), 2**63 - 1),
    "unsigned long long": (0, 2**64 - 1),
}
FLOATS = {"float": 24, "double": 53}
OTHERS = ("boolean", "char", "string", "string<4>")


def fits(to: str, from_: str) -> bool:
    """Return whether every value of one type is one of the other."""
    if to == from_ or (to, from_) == ("double", "float"):
        return True
    if from_ not in INTEGERS:
        return False
    low, high = INTEGERS[from_]
    if to in FLOATS:
        return -(2 ** FLOATS[to]) <= low and high <= 2 ** FLOATS[to]
    return to in INTEGERS and INTEGERS[to][0] <= low and high <= INTEGERS[to][1]


def run_adapter(
    adapter: Component, *samples: object, check: str = "first"
) -> tuple[list[Any], list[str]]:
    """Return what an adapter makes of samples, and the errors of its cycles."""
    system, out, back = connected(adapter, check)
    failures: list[str] = []
    system.on_failure = lambda failure: failures.append(str(failure.error))
    for sample in samples:
        out.write(sample)
    system.activate("X0")
    system.run(50_000_000)
    found = []
    while back.is_new():
        found.append(back.read())
    return found, failures


def test_numbers_go_where_every_one_of_them_fits(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    types = [*INTEGERS, *FLOATS, *OTHERS]
    members = "".join(f"{type_} m{i}; " for i, type_ in enumerate(types))
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text(f"struct A {{ {members}}}; struct B {{ {members}}};\n")
    pairs = [(i, j) for i in range(len(types)) for j in range(len(types))]
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n'
        + "".join(
            f'[adapter.P{i}x{j}]\nfrom = "A"\nto = "B"\nmap = {{ m{i} = "m{j}" }}\n'
            for i, j in pairs
        )
    )
    assert run(["generate", "--no-cache"]) == 2
    errors = capfd.readouterr().err
    refused = {
        (i, j) for i, j in pairs if f"error[ADP0004]: adapter 'P{i}x{j}'" in errors
    }
    assert refused == {(i, j) for i, j in pairs if not fits(types[i], types[j])}
    assert f"{len(refused)} errors" in errors


def test_an_adapter_converts_all_that_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text(
        "module AdM { struct Time { unsigned long sec; };\n"
        "struct Base { Time tm; };\n"
        "struct A : Base { float v; sequence<long> id; short class; long other; };\n"
        "struct Deep { double lambda; long n; };\n"
        "struct B { Time tm; Deep inner; sequence<long> id; double other; };\n"
        "typedef Deep Alias; struct C { Alias inner; };\n"
        "typedef C D; struct E { D c; }; };\n"
    )
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n[output]\npackage = "adapted"\n'
        '[adapter.AToB]\nfrom = "AdM::A"\nto = "AdM::B"\n'
        'map = { "inner.lambda" = "v", inner.n = "class" }\n'.replace(
            "inner.n", '"inner.n"'
        )
        + '[adapter.BToC]\nfrom = "::AdM::B"\nto = "AdM::C"\n'
        '[adapter.BToE]\nfrom = "AdM::B"\nto = "AdM::E"\nmap = { "c.inner.n" = "inner.n" }\n'
    )
    assert run(["generate", "-q", "--no-cache"]) == 0
    assert run(["check", "--no-cache"]) == 0
    monkeypatch.syspath_prepend(str(tmp_path / "generated"))
    adm = import_module("adapted.adm")
    factories = component_types(Path("generated")).factories
    assert factories["AToB"] == "adapted.adapters.a_to_b:AToB"

    def converted(name: str, module: str, *samples: object) -> list[object]:
        adapter = getattr(import_module(f"adapted.adapters.{module}"), name)("X0")
        return run_adapter(adapter, *samples)[0]

    first = adm.A(adm.Time(3), 0.5, [1, 2], 7, 9)
    second = adm.A(adm.Time(4), -0.5, [], -7, 9)
    # `other` is a long here and a double there: it is not copied without a line for it.
    assert converted("AToB", "a_to_b", first, second) == [
        adm.B(adm.Time(3), adm.Deep(0.5, 7), [1, 2], 0.0),
        adm.B(adm.Time(4), adm.Deep(-0.5, -7), [], 0.0),
    ]
    whole = adm.B(adm.Time(1), adm.Deep(2.0, 3), [4], 5.0)
    assert converted("BToC", "b_to_c", whole) == [adm.C(adm.Deep(2.0, 3))]
    assert converted("BToE", "b_to_e", whole) == [adm.E(adm.C(adm.Deep(0.0, 3)))]


def test_another_file_alone_needs_no_adapter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text("struct A { long x; };\n")
    Path("other.idl").write_text("struct Z { long x; };\n")
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n[adapter.Same]\nfrom = "A"\nto = "A"\n'
    )
    assert run(["generate", "-q", "-o", "out", "other.idl"]) == 0
    assert not (tmp_path / "out/generated/robots/adapters").exists()
    assert run(["generate", "-q"]) == 0
    assert (tmp_path / "generated/robots/adapters/same.py").is_file()


def test_an_adapter_is_in_the_cache_s_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTGEN_CACHE_DIR", str(tmp_path / "cache"))
    Path("t.idl").write_text("struct A { long x; long y; };\n")
    text = '[sources]\npaths = ["t.idl"]\n[adapter.Swap]\nfrom = "A"\nto = "A"\nmap = {0}\n'
    for pair in ('{ x = "y" }', '{ y = "x" }'):
        Path("rtgen.toml").write_text(text.replace("{0}", pair))
        assert run(["generate", "-q"]) == 0
        made = Path("generated/robots/adapters/swap.py").read_text()
        to, from_ = pair.strip('{}" ').split(' = "')
        assert f"made.{to} = sample.{from_}\n" in made


def test_components_of_adapters_are_inspected(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text("struct A { long x; };\n")
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n[adapter.Same]\nfrom = "A"\nto = "A"\n'
    )
    assert run(["inspect"]) == 0
    assert "component Same" in capfd.readouterr().out


def test_an_adapter_converts_units(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text(
        "module AdU { struct Pose { double x; double y; float heading; };\n"
        "struct Sent { long count; Pose at; sequence<double> angles; double heat; };\n"
        "struct Taken { long count; Pose at; sequence<double> angles; double heat; };\n"
        'struct Mm { @unit("mm") long way; };\n'
        "struct M { double way; ///< Way [m].\n};\n};\n"
    )
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n[output]\npackage = "united"\n'
        '[adapter.Units]\nfrom = "AdU::Sent"\nto = "AdU::Taken"\n'
        'units = { "at.heading" = ["deg", "rad"], angles = ["rpm", "rad/s"], '
        'heat = ["deg C", "K"] }\n'
        '[adapter.Way]\nfrom = "AdU::Mm"\nto = "AdU::M"\nmap = { way = "way" }\n'
    )
    assert run(["generate", "-q", "--no-cache"]) == 0
    monkeypatch.syspath_prepend(str(tmp_path / "generated"))
    adu = import_module("united.adu")
    sent = adu.Sent(3, adu.Pose(1.0, 2.0, 180.0), [60.0, -30.0], 20.0)
    units = import_module("united.adapters.units").Units("X0")
    [taken], _ = run_adapter(units, sent)
    [way], _ = run_adapter(import_module("united.adapters.way").Way("X0"), adu.Mm(1500))
    assert taken.count == 3
    assert (taken.at.x, taken.at.y) == (1.0, 2.0)
    assert taken.at.heading == pytest.approx(pi)
    assert list(taken.angles) == pytest.approx([tau, -tau / 2])
    assert taken.heat == pytest.approx(293.15)
    assert way == adu.M(1.5)
    assert sent.at.heading == 180.0
    profile = Path("generated/united/components/units/RTC.xml").read_text()
    assert 'rtc:unit="deg, rpm, deg C"' in profile


@pytest.mark.sampled(1)
@pytest.mark.parametrize("numeric", ["list", "array", "numpy"])
def test_an_adapter_converts_numbers_of_several_dimensions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, numeric: str
) -> None:
    package = f"grids_{numeric}"
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text(
        "module AdG { typedef double Three[3]; struct Grid { float cells[2][3];\n"
        "sequence<Three> rows; sequence<double> line; double cube[2][1][2]; }; };\n"
    )
    Path("rtgen.toml").write_text(
        f'[sources]\npaths = ["t.idl"]\n[output]\npackage = "{package}"\n'
        f'[python]\nnumeric = "{numeric}"\n'
        '[adapter.Mm]\nfrom = "AdG::Grid"\nto = "AdG::Grid"\n'
        'units = { cells = ["m", "mm"], rows = ["deg C", "K"], line = ["rpm", "rad/s"], '
        'cube = ["m", "mm"] }\n'
    )
    assert run(["generate", "-q", "--no-cache"]) == 0
    check_by_mypy([tmp_path / "generated" / package], [tmp_path / "generated"])
    monkeypatch.syspath_prepend(str(tmp_path / "generated"))
    adapter = import_module(f"{package}.adapters.mm").Mm("X0")
    sent = import_module(f"{package}.adg").Grid(
        [[1, 2, 3], [4, 5, 6]], [[0, 10, 20]], [60, 30], [[[1, 2]], [[3, 4]]]
    )
    [taken], _ = run_adapter(adapter, sent)
    assert [list(row) for row in taken.cells] == [
        [1000, 2000, 3000],
        [4000, 5000, 6000],
    ]
    assert [list(row) for row in taken.rows] == [
        pytest.approx([273.15, 283.15, 293.15])
    ]
    assert list(taken.line) == pytest.approx([tau, pi])
    assert [list(inner[0]) for inner in taken.cube] == [[1000, 2000], [3000, 4000]]


FORMS = ("list", "array", "numpy")


@pytest.fixture(scope="module")
def forms(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Generate adapters between all forms of numbers, with and without conversion of units."""
    folder = tmp_path_factory.mktemp("forms")
    members = (
        "sequence<double> line; sequence<float> few; @optional sequence<long> ids;"
    )
    formed = members.replace("sequence", '@numeric("{0}") sequence')
    structs = "".join(
        f"struct {form.title()} {{ {formed.replace('{0}', form)}"
        f' @numeric("{form.replace("array", "list")}") float grid[1][2]; }};'
        for form in FORMS
    )
    records = "".join(
        f'struct {form.title()}P {{ @numeric("{form}") sequence<P> points; }};'
        for form in ("list", "numpy")
    )
    (folder / "t.idl").write_text(
        f"module AdC {{ {structs} struct P {{ float x; long y[2]; }}; {records} }};"
    )
    table = '[adapter.{0}To{1}{2}]\nfrom = "AdC::{0}"\nto = "AdC::{1}"\n'
    scaled = '"few" = ["m", "mm"], "line" = ["m", "mm"], "grid" = ["m", "mm"]'
    (folder / "rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n[output]\npackage = "formed"\n'
        + "".join(
            table.format(one.title(), other.title(), "")
            + table.format(one.title(), other.title(), "Mm")
            + f"units = {{ {scaled} }}\n"
            for one in FORMS
            for other in FORMS
        )
        + table.format("ListP", "NumpyP", "")
        + table.format("NumpyP", "ListP", "")
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert run(["generate", "-q", "--no-cache"]) == 0
        patch.syspath_prepend(str(folder / "generated"))
        yield folder / "generated"


@pytest.mark.sampled(0)
def test_adapters_between_forms_pass_a_type_checker(forms: Path) -> None:
    check_by_mypy([forms / "formed"], [forms])


def in_form(form: str, numbers: list[Any], code: str) -> Any:
    if form == "numpy":
        return numpy.array(numbers, code)
    return NumericArray(code, numbers) if form == "array" else numbers


def adapter_between(one: str, other: str, suffix: str = "") -> Component:
    name = f"{one}_to_{other}{suffix and '_'}{suffix}"
    class_ = name.title().replace("_", "")
    made = getattr(import_module(f"formed.adapters.{name}"), class_)("X0")
    assert isinstance(made, Component)
    return made


@pytest.mark.parametrize("other", FORMS)
@pytest.mark.parametrize("one", FORMS)
def test_an_adapter_converts_forms(one: str, other: str, forms: Path) -> None:
    types = import_module("formed.adc")
    line, few = [float(n) for n in range(70)], [0.5, float("inf")]
    grid = in_form(one.replace("array", "list"), [[1.0, 2.0]], "f")
    numbers = in_form(one, line, "d"), in_form(one, few, "f"), in_form(one, [7], "i")
    sent = getattr(types, one.title())(*numbers, grid)
    [made], failures = run_adapter(adapter_between(one, other), sent)
    [mm], more = run_adapter(adapter_between(one, other, "mm"), sent)
    assert failures == more == []
    kept = list if other == "list" else numpy.ndarray if other == "numpy" else object
    assert all(isinstance(v, kept) for v in (made.line, made.ids, made.grid, mm.few))
    assert (*made.line, *made.few, *made.ids) == (*line, *few, 7)
    assert (*mm.line, *mm.few, *mm.ids) == (*(1000 * n for n in line), 500.0, few[1], 7)
    assert [[*row] for row in (*made.grid, *mm.grid)] == [[1.0, 2.0], [1000.0, 2000.0]]
    assert type(made).from_cdr(made.to_cdr()) == made
    sent.ids = None
    [made], _ = run_adapter(adapter_between(one, other), sent)
    assert made.ids is None


@pytest.mark.parametrize("other", FORMS)
@pytest.mark.parametrize("one", FORMS)
def test_numbers_beyond_float_are_reported_with_their_place(
    one: str, other: str, forms: Path
) -> None:
    """An array of numpy has no place for them; other forms have, until they are written."""
    types = import_module("formed.adc")
    grid = in_form(one.replace("array", "list"), [[1.0, 2.0]], "f")
    few = in_form(one, [1.0, 2.0**120], "f")
    sent = getattr(types, one.title())(in_form(one, [1.0], "d"), few, None, grid)
    found, failures = run_adapter(adapter_between(one, other, "mm"), sent)
    text = f"{other.title()}.few[1]: {1000 * 2.0**120} is out of the range of float"
    port = "" if other == "numpy" else "X0.output: "
    assert (found, failures) == ([], [port + text])


def test_structs_of_numbers_change_their_form(forms: Path) -> None:
    types = import_module("formed.adc")
    listed = types.ListP([types.P(1.0, [2, 3]), types.P(4.0, [5, 6])])
    to_numpy, to_list = (
        getattr(import_module(f"formed.adapters.{name}"), class_)("X0")
        for name, class_ in (
            ("list_p_to_numpy_p", "ListPToNumpyP"),
            ("numpy_p_to_list_p", "NumpyPToListP"),
        )
    )
    [records], _ = run_adapter(to_numpy, listed)
    assert records.points["y"].tolist() == [[2, 3], [5, 6]]
    [back], _ = run_adapter(to_list, records)
    assert back == listed
    again = import_module("formed.adapters.list_p_to_numpy_p").ListPToNumpyP("X0")
    _, [failure] = run_adapter(
        again, types.ListP([types.P(1e300, [2, 3])]), check="never"
    )
    assert failure.startswith("NumpyP.points: ")


@pytest.mark.parametrize(
    ("units", "code", "word"),
    [
        ('{ "v" = ["deg", "m"] }', "ADP0005", "'v' is in m, 'v' in deg"),
        ('{ "v" = ["deg", "wags"] }', "ADP0005", "'v' is in wags"),
        ('{ "n" = ["m", "mm"] }', "ADP0004", "not float or double"),
        ('{ "x" = ["m", "mm"] }', "ADP0003", "no member 'x'"),
        ('{ "own" = ["m", "mm"] }', "ADP0005", "its definition rad"),
        ('{ "v" = ["m"] }', "PRJ0003", "UNIT"),
    ],
)
def test_units_that_an_adapter_refuses(
    units: str,
    code: str,
    word: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.idl").write_text(
        'struct A { double v; long n; @unit("rad") double own; };\n'
    )
    Path("rtgen.toml").write_text(
        '[sources]\npaths = ["t.idl"]\n'
        f'[adapter.X]\nfrom = "A"\nto = "A"\nunits = {units}\n'
    )
    assert run(["generate", "--no-cache"]) == 2
    errors = capfd.readouterr().err
    assert code in errors
    assert word in errors
