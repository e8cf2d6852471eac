"""Table 1 and its extension: the IDL of each form of a parameter, and forms without IDL."""

from __future__ import annotations

import subprocess
from pathlib import Path

import programs
import pytest
from boards import MOTOR, SERVER, emit, joined, texts

from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.idl import load

SCALARS = {
    "char_t": "char",
    "uchar_t": "char",
    "int8_t": "octet",
    "uint8_t": "octet",
    "int16_t": "short",
    "uint16_t": "unsigned short",
    "int32_t": "long",
    "uint32_t": "unsigned long",
    "int64_t": "long long",
    "uint64_t": "unsigned long long",
    "float32_t": "float",
    "double64_t": "double",
    "bool_t": "boolean",
    "ER": "long",
    "ID": "long",
    "PRI": "long",
    "int_t": "long",
    "uint_t": "unsigned long",
    "short_t": "short",
    "ushort_t": "unsigned short",
    "long_t": "long",
    "ulong_t": "unsigned long",
    "intptr_t": "long",
    "schar_t": "octet",
    "int": "long",
    "unsigned short": "unsigned short",
}
"""Table 1, and the additions of the contract."""

FORMS = {
    "[in,string] const char_t *p": "in string p",
    "[in,string(16)] const uint8_t *p": "in string p",
    "[out,string(16)] char_t *p": "out string p",
    "[in,string] const uint16_t *p": "in Face::UnsignedShortSeq p",
    "[in,size_is(4)] const int32_t *p": "in Face::LongSeq4 p",
    "[in,size_is(q)] const int32_t *p, [in] int8_t q": "in Face::LongSeq p, in octet q",
    "[in,size_is(q,9)] const int8_t *p, [in] int8_t q": "in Face::OctetSeq9 p, in octet q",
    "[in,size_is(q),string(5)] const char_t **p, [in] int8_t q": (
        "in Face::StringSeq p, in octet q"
    ),
    "[out,size_is(8),count_is(*q)] bool_t *p, [inout] int8_t *q": (
        "out Face::BooleanSeq8 p, inout octet q"
    ),
    "[in,nullable] const int16_t *p": "in Face::ShortSeq1 p",
    "[in,string,nullable] const char_t *p": "in Face::StringSeq1 p",
    "[in] const int16_t p[3]": "in Face::ShortArray3 p",
    "[in] const int16_t p[2][3]": "in Face::ShortArray2x3 p",
    "[in] struct tagP p": "in tagP p",
    "[inout] struct tagP *p": "inout tagP p",
    "[in] const Q *p": "in Q p",
    "[in] R p": "in R p",
    "[in,size_is(2)] const Q *p": "in Face::QSeq2 p",
    "[in] int32_t interface, [in] int32_t Interface": (
        "in long _interface, in long Interface_"
    ),
    "[in] int32_t _p": "in long x_p",
    "[in] struct tagP tagP": "in ::tagP tagP",
}
TRANSFERS = {
    "[send(sAlloc),size_is(q)] int8_t *p, [in] int32_t q": "in Face::OctetSeq p, in long q",
    "[receive(sAlloc),size_is(*q)] int8_t **p, [out] int32_t *q": (
        "out Face::OctetSeq p, out long q"
    ),
    "[receive(sAlloc),string] char_t **p": "out string p",
    "[receive(sAlloc),nullable] int32_t **p": "out Face::LongSeq1 p",
}
"""Parameters that are passed with their memory."""
PRELUDE = """\
[deviate] signature sAlloc {
  ER alloc( [in] int32_t size, [out] void **p ); ER dealloc( [in] const void *p );
};
struct tagP { int16_t x; };
typedef struct tagP Q;
typedef int64_t R;
enum eColour { RED, BLUE };
struct tagList { struct tagList *next; int16_t x; };
"""


def idl(folder: Path, text: str, name: str = "Face", options: str = "") -> str:
    """Return the IDL of a signature `sFace`."""
    emission, findings = emit(folder, {"f.cdl": joined(text, "sFace", options=options)})
    assert not has_errors(findings), findings
    return texts(emission.artifacts)[f"robots/tecs/f/{name}.idl"]


def accepted(path: Path) -> None:
    """Check that rtgen and omniidl accept the file."""
    result = load([path], root=path.parent)
    assert not has_errors(result.diagnostics), result.diagnostics
    if programs.OMNIIDL is not None:
        run = subprocess.run(
            [programs.OMNIIDL, "-b", "dump", str(path)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert run.returncode == 0, run.stdout + run.stderr


def test_figure_8(tmp_path: Path) -> None:
    emission, findings = emit(tmp_path, {"server.cdl": joined(SERVER, "sServer")})
    assert not findings
    text = texts(emission.artifacts)["robots/tecs/server/Server.idl"]
    assert """\
interface Server {
    long func1(in long indata);
    long func2(out char outdata);
    long func3(in long long indata, inout unsigned long iodata);
};
""" in text


def test_scalars(tmp_path: Path) -> None:
    functions = [f"void f{i}( [in] {type_} p );" for i, type_ in enumerate(SCALARS)]
    text = idl(tmp_path, f"signature sFace {{ {' '.join(functions)} }};\n")
    for number, primitive in enumerate(SCALARS.values()):
        assert f"    void f{number}(in {primitive} p);\n" in text


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ("longBits=64", ("long long", "long", "long")),
        ("tdr=little", ("long long", "long long", "long")),
        ("tdr=big, longBits=32", ("long", "long long", "long")),
        ("intptrBits=64, intBits=16", ("long", "long long", "short")),
    ],
)
def test_widths(tmp_path: Path, options: str, expected: tuple[str, str, str]) -> None:
    text = "signature sFace { long_t f( [in] intptr_t p, [in] int_t q ); };\n"
    long, intptr, int_ = expected
    assert f"{long} f(in {intptr} p, in {int_} q);" in idl(
        tmp_path, text, options=options
    )


def test_forms(tmp_path: Path) -> None:
    functions = [f"ER f{i}( {form} );" for i, form in enumerate(FORMS)]
    text = idl(tmp_path, f"{PRELUDE}signature sFace {{ {' '.join(functions)} }};\n")
    for number, parameters in enumerate(FORMS.values()):
        assert f"    long f{number}({parameters});\n" in text
    path = tmp_path / "Face.idl"
    path.write_text(text, encoding="utf-8")
    accepted(path)


def test_send_and_receive(tmp_path: Path) -> None:
    functions = [f"ER f{i}( {form} );" for i, form in enumerate(TRANSFERS)]
    specified = ", ".join(
        f"eServer.f{i}.p = Heap.eAlloc" for i in range(len(TRANSFERS))
    )
    text = joined(f"{PRELUDE}signature sFace {{ {' '.join(functions)} }};\n", "sFace")
    text = text.replace(
        "cell tServer0 Server0", f"[allocator( {specified} )]\ncell tServer0 Server0"
    )
    heap = "celltype tHeap { entry sAlloc eAlloc; };\ncell tHeap Heap {};\n"
    emission, _ = emit(
        tmp_path,
        {"f.cdl": text.replace("celltype tServer0", heap + "celltype tServer0")},
    )
    found = texts(emission.artifacts)["robots/tecs/f/Face.idl"]
    for number, parameters in enumerate(TRANSFERS.values()):
        assert f"    long f{number}({parameters});\n" in found


def test_array_as_any(tmp_path: Path) -> None:
    text = "signature sFace { ER f( [in,size_is(n)] const int16_t *p, [in] int32_t n ); };\n"
    assert "long f(in any p, in long n);" in idl(tmp_path, text, options="array=any")


def test_oneway(tmp_path: Path) -> None:
    text = "signature sFace { [oneway] void f( void ); [oneway] ER g( [in] bool_t b ); };\n"
    found = idl(tmp_path, text)
    assert "    oneway void f();\n    long g(in boolean b);\n" in found


def test_names_of_the_interface(tmp_path: Path) -> None:
    text = (
        "struct Face { int8_t a; };\n"
        "signature sFace { ER f( [in] struct Face a ); ER F_( void ); };\n"
    )
    found = idl(tmp_path, text)
    assert "struct Face_ {" in found
    assert "    long f(in Face_ a);\n    long F_();\n" in found


def test_modules_structs_and_constants(tmp_path: Path) -> None:
    emission, findings = emit(tmp_path, {"board.cdl": joined(MOTOR, "nBoard::sMotor")})
    assert not findings
    text = texts(emission.artifacts)["robots/tecs/board/Motor.idl"]
    for line in (
        "const long WHEELS = 2;",
        "module nBoard {",
        "    const float GAIN = 1.5;",
        "    const double FAR = 1.5e+300;",
        "    const boolean GEARED = TRUE;",
        "    const char MARK = 'm';",
        "    typedef short Level;",
        "        sequence<octet> data;",
        "        octet grid[2][3];",
        "    typedef nBoard::tagPoint Point;",
        "    interface Motor {",
    ):
        assert f"\n{line}\n" in text
    path = tmp_path / "Motor.idl"
    path.write_text(text, encoding="utf-8")
    accepted(path)


def test_files_that_share_types(tmp_path: Path) -> None:
    signatures = (
        "signature sOne { ER f( [in] struct tagP p ); };\n"
        "signature sTwo { ER f( [in] const Q *p ); };\n"
    )
    emission, findings = emit(
        tmp_path, {"board.cdl": joined(PRELUDE + signatures, "sOne", "sTwo")}
    )
    assert not findings
    for name in ("One", "Two"):
        text = texts(emission.artifacts)[f"robots/tecs/board/{name}.idl"]
        (tmp_path / f"{name}.idl").write_text(text, encoding="utf-8")
        accepted(tmp_path / f"{name}.idl")
    both = tmp_path / "both.idl"
    both.write_text('#include "One.idl"\n#include "Two.idl"\n', encoding="utf-8")
    accepted(both)


@pytest.mark.parametrize(
    ("function", "what"),
    [
        ("ER f( [in] enum eColour p );", "`enum eColour` cannot be transferred"),
        ("ER f( [in] int128_t p );", "no integer of the width of `int128_t`"),
        ("ER f( [in] const void *p );", "no value travels"),
        ("int128_t f( void );", "what f returns has no IDL"),
        ("ER f( [in] const struct tagList *p );", "holds itself"),
    ],
)
def test_what_has_no_idl(tmp_path: Path, function: str, what: str) -> None:
    text = (
        f"{PRELUDE}signature sFace {{\n  ER fine( [in] int8_t p );\n  {function}\n}};\n"
    )
    emission, findings = emit(tmp_path, {"f.cdl": joined(text, "sFace")})
    assert not emission.artifacts
    (finding,) = findings
    assert finding.code == "CDL1003"
    assert what in finding.message
    assert finding.span is not None
    line = text.split("\n")[finding.span.line - 1]
    assert line.strip() == function


COMMENTED = """struct tagMove {
    double64_t speed, turn; /**< Forward [m/s], and left [rad/s]. */
    /** Encoder [inc]. */
    int32_t counts;
    int32_t silent;
};
signature sDrive {
    ER move( [in] const struct tagMove *way );
};
"""


def test_comments_of_members_with_their_units_are_in_the_idl(tmp_path: Path) -> None:
    emission, findings = emit(tmp_path, {"drive.cdl": joined(COMMENTED, "sDrive")})
    assert not findings
    text = texts(emission.artifacts)["robots/tecs/drive/Drive.idl"]
    assert """\
struct tagMove {
    /** Forward [m/s], and left [rad/s]. */
    double speed;
    /** Forward [m/s], and left [rad/s]. */
    double turn;
    /** Encoder [inc]. */
    long counts;
    long silent;
};
""" in text
    path = tmp_path / "Drive.idl"
    path.write_text(text, encoding="utf-8")
    accepted(path)
