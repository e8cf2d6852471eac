"""Reading of CDL files: encodings, imports, C headers, the prelude, the grammar of a whole file."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtgen.cli import run
from rtgen.compiler.diagnostics import Severity
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.cdl import load, read_text
from rtgen.compiler.frontends.kit.character_rules import OCTET_OF_LITERAL
from rtgen.compiler.model.c_types import (
    CPointerType,
    CScalarType,
    CStructType,
    CTypedefType,
    resolve,
)
from rtgen.compiler.model.tecs import (
    Cell,
    Celltype,
    Signature,
    TecsConst,
    TecsDeclaration,
    TecsStruct,
    TecsTypedef,
)
from rtgen.facts.tdr import Scalar

HERE = Path(__file__).parent
JAPANESE = '/* 表示ソフト */ const char_t *const A = "能力"; const int32_t B = 1;\n'


def _codes(result: FrontendResult) -> list[str]:
    return [d.code for d in result.diagnostics]


def _read(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    include: tuple[str, ...] = (),
    define: dict[str, str] | None = None,
    prelude: bool = True,
    **files: str,
) -> FrontendResult:
    """Return the result of reading a folder of files; `main_cdl` is the main file."""
    for name, text in files.items():
        path = folder / name.replace("__", "/").replace("_", ".")
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    monkeypatch.chdir(folder)
    return load(
        [Path("main.cdl")],
        root=folder,
        include=[Path(name) for name in include],
        define=define,
        prelude=prelude,
    )


def _named(result: FrontendResult, name: str) -> TecsDeclaration:
    (unit,) = result.model.tecs
    return next(d for d in unit.declarations if d.name[-1] == name)


def test_every_construct(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HERE)
    result = load([Path("constructs.cdl")], root=HERE)
    errors = [d for d in result.diagnostics if d.severity is Severity.ERROR]
    assert errors == []
    keys = [file.key for file in result.model.files]
    assert sorted(keys) == ["constructs.cdl", "parts.cdl", "sized.h", "types.h"]
    wide = _named(result, "Wide")
    assert isinstance(wide, TecsTypedef)
    assert wide.from_c
    assert resolve(wide.type) == CScalarType(Scalar.LONG_LONG)
    board = _named(result, "board")
    assert isinstance(board, TecsStruct)
    assert [m.name for m in board.members] == ["version", "inside", "flag", "next"]
    assert str(board.members[0].type) == "unsigned char[6]"


def test_shift_jis_backslashes_end_no_string(tmp_path: Path) -> None:
    path = tmp_path / "main.cdl"
    path.write_bytes(JAPANESE.encode("cp932"))
    result = load([path], root=tmp_path)
    assert {*_codes(result)} == {OCTET_OF_LITERAL.code}
    text = _named(result, "A")
    assert isinstance(text, TecsConst)
    assert text.value == "能力"
    assert isinstance(_named(result, "B"), TecsConst)


def test_imports_are_read_once_and_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        include=("lib",),
        main_cdl='import( <a.cdl> ); import( "b.cdl" ); const T C = A + B;',
        lib__a_cdl='import( "b.cdl" ); typedef int32_t T; const T A = B;',
        lib__b_cdl="const int32_t B = 1;",
    )
    assert _codes(result) == ["CDL0008"]
    (unit,) = result.model.tecs
    assert [d.scoped for d in unit.declarations] == ["B", "T", "A", "C"]
    assert [d.file for d in unit.declarations][:2] == ["lib/b.cdl", "lib/a.cdl"]
    missing = {d.path.name for d in result.dependencies if d.sha256 is None}
    assert missing == {"a.cdl", "b.cdl"}
    (main,) = [file for file in result.model.files if file.main]
    assert main.includes == ("lib/a.cdl",)


def test_each_main_file_is_a_unit(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}.cdl").write_text("const int32_t N = 1;\n")
    paths = [tmp_path / "one.cdl", tmp_path / "two.cdl"]
    result = load(paths, root=tmp_path)
    assert _codes(result) == []
    assert [unit.key for unit in result.model.tecs] == ["one.cdl", "two.cdl"]


def test_missing_kernel_files_are_errors_beside_other_errors() -> None:
    fine = (
        'import( <kernel.cdl> ); import_C( "tecs.h" ); signature s { ER f( void ); };'
    )
    assert [d.severity for d in read_text(fine)[1]] == [
        Severity.WARNING,
        Severity.WARNING,
        Severity.NOTE,
    ]
    wrong = fine + "cell tKernel Kernel { };"
    errors = {d.code for d in read_text(wrong)[1] if d.severity is Severity.ERROR}
    assert {"CDL0006", "CDL0900"} <= errors


def test_the_prelude() -> None:
    text = "signature s { ER_UINT f( [in] int_t ID, [out] SYSTIM *PRI ); };"
    unit, findings = read_text(text)
    assert [d.code for d in findings] == ["CDL0009"]
    (signature,) = unit.declarations
    assert isinstance(signature, Signature)
    (function,) = signature.functions
    assert str(function.returns) == "ER_UINT"
    assert resolve(function.returns) == CScalarType(Scalar.INT)
    assert [p.name for p in function.parameters] == ["ID", "PRI"]
    pointer = function.parameters[1].type
    assert isinstance(pointer, CPointerType)
    assert resolve(pointer.target) == CScalarType(Scalar.ULONG)
    strict = {d.code for d in read_text(text, prelude=False)[1]}
    assert strict == {"CDL0300"}


def test_a_declared_type_goes_before_the_prelude() -> None:
    unit, findings = read_text("typedef int64_t ER; signature s { ER f( void ); };")
    assert findings == ()
    signature = unit.declarations[-1]
    assert isinstance(signature, Signature)
    returns = signature.functions[0].returns
    assert isinstance(returns, CTypedefType)
    assert resolve(returns) == CScalarType(Scalar.INT64)


def test_docs_belong_to_what_follows_them() -> None:
    text = (
        "/** Moves.\n * Twice. */\nsignature s {\n  // Stops.\n  void f( void );\n};\n"
    )
    (signature,) = read_text(text)[0].declarations
    assert isinstance(signature, Signature)
    assert signature.doc == "Moves.\nTwice."
    assert signature.functions[0].doc == "Stops."


def test_function_ids_count_from_one() -> None:
    text = "signature s { void a( void ); void b( void ); [oneway] void c( void ); };"
    (signature,) = read_text(text)[0].declarations
    assert isinstance(signature, Signature)
    found = [(f.id, f.name, f.oneway) for f in signature.functions]
    assert found == [(1, "a", False), (2, "b", False), (3, "c", True)]


def test_mistakes_do_not_hide_one_another() -> None:
    text = """
signature s { void f( [in] Unknown a ); void g( int8_t b ); int8_t c; };
const int32_t A = ;
celltype t { attr { int32_t x = ; int32_t y = Z; }; entry s e };
struct u { int8_t a; int8_t a; };
"""
    found = [(d.code, d.span.line if d.span else 0) for d in read_text(text)[1]]
    assert found == [
        ("CDL0300", 2),
        ("CDL0406", 2),
        ("CDL0402", 2),
        ("CDL0200", 3),
        ("CDL0200", 4),
        ("CDL0804", 4),
        ("CDL0201", 4),
        ("CDL0307", 5),
    ]


HEADERS = {
    "typedef unsigned char T;": "unsigned char",
    "typedef char T;": "char",
    "typedef long unsigned int T;": "unsigned long",
    "typedef short int T;": "short",
    "typedef unsigned T;": "unsigned int",
    "typedef float T;": "float32_t",
    "typedef _Bool T;": "bool_t",
    "#include <stdint.h>\ntypedef uint16_t T;": "uint16_t",
    "#include <stdint.h>\ntypedef intptr_t T;": "intptr_t",
    "#include <stdbool.h>\ntypedef bool T;": "bool_t",
    "typedef const int *T;": "const int*",
    "typedef int T[2][sizeof(int) == 4 ? 3 : 3];": "struct unknown T",  # the compiler's
    "typedef int T[1 / 0];": "struct unknown T",
    "typedef int T[1 << 70];": "struct unknown T",
    "typedef int T[0];": "int[]",
    "enum { N = -7 / 2, M = 7 % 4, K = 'c' - 'a', L = 1 ? 0x10 : 0, O = 010 };\n"
    "typedef int T[(M + K + L + O) * -N];": "int[87]",
    "enum { A = 1 << 3, B = A >> 1, C = ~0 & 6 | 1, D = (int)3 == 3 && !0 };\n"
    "typedef int T[A + B + C + D];": "int[20]",
    "typedef union { int a; } T;": "struct unknown T",
    "typedef long double T;": "struct unknown T",
    "typedef signed char T;": "signed char",
    "typedef void (*T)(int a, ...);": "void(*)(int)",
    "typedef volatile int *const T;": "volatile int* const",
    "struct s { union { int a; } u; struct { int x; }; int : 3; };\n"
    "typedef struct s T;": "struct s",
    "enum { N = 2, M };\ntypedef int T[N * M - (1 << 1)];": "int[4]",
    "typedef int (*T)(void);": "int(*)(void)",
    "typedef struct s *T;": "struct s*",
    "typedef enum e { A } T;": "enum e",
    "__extension__ typedef long long T __attribute__((aligned(8)));": "long long",
    "typedef int T; typedef int T;": "int",
    'static inline int f(void) { asm("nop"); return 1; }\ntypedef int T;': "int",
    "#pragma pack(1)\ntypedef int T;": "int",
    "#ifdef TECSGEN\ntypedef int T;\n#else\n#error no\n#endif": "int",
    "#define DECLARE(name) typedef int name\nDECLARE(T);": "int",
    "#if __GNUC__ && __LP64__\ntypedef __INT64_TYPE__ T;\n#else\n#error who\n#endif": "long",
    '#define I static __inline\nI void f(void) { __asm__ volatile("nop"); }\ntypedef int T;': "int",
}


@pytest.mark.parametrize("header", HEADERS)
def test_types_of_c_headers(
    header: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "types.h" ); typedef T Copy;',
        types_h=header,
    )
    assert _codes(result) == []
    declared = _named(result, "T")
    assert isinstance(declared, TecsTypedef)
    assert str(declared.type) == HEADERS[header]


def test_headers_take_definitions_and_search_paths(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        include=("inc",),
        define={"GIVEN": "1"},
        main_cdl='import_C( "types.h", "WIDE=2,FLAG" ); typedef T Copy;',
        inc__types_h='#include "more.h"\n#if WIDE == 2 && FLAG && GIVEN\ntypedef M T;\n#endif\n',
        inc__more_h="typedef long M;\n",
    )
    assert _codes(result) == []
    assert {file.key for file in result.model.files} == {
        "main.cdl",
        "inc/types.h",
        "inc/more.h",
    }


def test_macros_of_a_header_end_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "types.h" ); import_C( "more.h" ); typedef T Copy;',
        types_h="#undef __LP64__\n#define TECSGEN 2\n#define __GNUC__ 3\n#define A 1\n",
        more_h="#if __LP64__ && TECSGEN == 1 && __GNUC__ == 12 && !defined(A)\n"
        "typedef int T;\n#else\n#error changed\n#endif\n",
    )
    assert _codes(result) == []


def test_what_no_header_declares_right_is_reported_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "types.h" ); const Good A = 1; const Odd B = 1;',
        types_h="typedef nothing Odd;\ntypedef int Good;\n",
    )
    assert _codes(result) == ["CDL0901", "CDL0300"]


@pytest.mark.parametrize(
    "directive",
    [
        *("#define", "#undef", "#ifdef", "#ifndef", "#if", "#elif", "#include"),
        *("#if !", "#if !defined", "#if !defined("),
        "#ifndef A\n#define\n#endif",
    ],
)
def test_directives_of_headers_that_are_cut_off(
    directive: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "types.h" );',
        types_h=f"{directive}\n",
    )
    assert _codes(result) == ["CDL0901"]


def test_a_header_uses_typedefs_of_headers_imported_before_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "kernel.h" ); import_C( "log.h" );',
        kernel_h="typedef unsigned int uint_t;\nenum { DEPTH = 4 };\n"
        "typedef struct { int a; } POINT;\n",
        log_h="typedef struct { uint_t kind; POINT at[DEPTH]; } T;\n"
        "typedef struct { uint_t other; } OTHER;\ntypedef unsigned int uint_t;\n",
    )
    assert _codes(result) == []
    (unit,) = result.model.tecs
    declared = unit.find(("T",), TecsTypedef)
    assert isinstance(declared, TecsTypedef)
    tag = resolve(declared.type)
    assert isinstance(tag, CStructType)
    assert tag.tag == ("T",)
    struct = unit.find(tag.tag, TecsStruct)
    assert isinstance(struct, TecsStruct)
    assert [str(member.type) for member in struct.members] == ["uint_t", "POINT[4]"]


def test_a_header_read_twice_declares_its_structs_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "one.h" ); import_C( "two.h" );',
        one_h='#include "point.h"\ntypedef struct { POINT at; } ONE;\n',
        two_h='#include "point.h"\ntypedef struct { POINT at; int b; } TWO;\n',
        point_h="typedef struct { int x; int y; } POINT;\n",
    )
    assert _codes(result) == []
    (unit,) = result.model.tecs
    assert len([d for d in unit.declarations if isinstance(d, TecsStruct)]) == 3


def test_two_headers_that_disagree_about_a_typedef_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl='import_C( "one.h" ); import_C( "two.h" );',
        one_h="typedef int T;\n",
        two_h="typedef short T;\n",
    )
    assert _codes(result) == ["CDL0905"]


def test_a_plug_in_of_tecsgen_may_import_what_a_later_one_is_applied_to() -> None:
    _, findings = read_text(
        'signature s { void f( void ); }; generate( MrubyBridgePlugin, s, "" ); '
        'generate( C2TECSBridgePlugin, nPosix::sMain, "" );'
    )
    assert [d.code for d in findings] == ["CDL0635"]


def test_joins_to_cells_that_plug_ins_make_are_in_the_model() -> None:
    unit, findings = read_text("""
        signature s { void f( void ); };
        celltype tS { entry s eS; };
        [active] celltype tA { call s cA; call s cB[2]; };
        generate( RepeatCellPlugin, tS, "" );
        cell tS S { };
        cell tA A { cA = rX::S_001.eS[1]; cB[0] = S_002.eS; cB[1] = S.eS; };
        """)
    assert {d.code for d in findings} == {"CDL0635"}
    cell = unit.find(("A",), Cell)
    assert isinstance(cell, Cell)
    assert [(j.port, j.index, j.target, j.target_index) for j in cell.joins] == [
        ("cA", None, ("rX", "S_001"), 1),
        ("cB", 0, ("S_002",), None),
        ("cB", 1, ("S",), None),
    ]
    assert [join.signature for join in cell.joins] == [("s",)] * 3


@pytest.mark.parametrize(
    ("declared", "text"),
    [
        ("char *a", "char*"),
        ("char_t *a", "char_t*"),
        ("unsigned char a", "unsigned char"),
        ("char_t (*a)[2]", "char_t(*)[2]"),
        ("char_t *a[2]", "char_t*[2]"),
        ("int8_t (*(*a)[3])[2]", "int8_t(*(*)[3])[2]"),
        ("int32_t (*a)( int8_t b )", "int32_t(*)(int8_t)"),
    ],
)
def test_types_are_shown_as_c_writes_them(declared: str, text: str) -> None:
    unit, _ = read_text(f"[active] celltype t {{ var {{ {declared}; }}; }};")
    (found,) = (d for d in unit.declarations if isinstance(d, Celltype))
    assert str(found.variables[0].type) == text


TOOL_INFORMATION = """
__tool_info__ ("tecsgen") {
    "base_dir" : [ "." ],
    "define_macro" : [ "WIDE=1" ],
    "import_path" : [ "parts", "c:/nowhere" ],
    "direct_import" : [ "types.cdl" ]
}
cell tServer Server { };
"""


def test_a_file_of_tecscde_imports_what_it_says_to_tecsgen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(
        tmp_path,
        monkeypatch,
        main_cdl=TOOL_INFORMATION,
        parts__types_cdl='import_C( "t.h" ); signature s { void f( [in] T a ); }; '
        "celltype tServer { entry s eS; };",
        parts__t_h="#if WIDE\ntypedef long T;\n#endif\n",
    )
    assert _codes(result) == ["CDL0608"]
    (unit,) = result.model.tecs
    assert unit.find(("Server",), Cell).file == "main.cdl"
    assert unit.find(("s",), Signature).file == "parts/types.cdl"
    (main,) = (file for file in result.model.files if file.main)
    assert main.includes == ("parts/types.cdl",)


def test_tool_information_with_a_missing_file_is_reported_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = _read(tmp_path, monkeypatch, main_cdl=TOOL_INFORMATION)
    (finding,) = (d for d in result.diagnostics if d.code == "CDL0006")
    assert finding.message == "types.cdl is not found"
    assert finding.span is not None
    assert (finding.span.line, finding.span.end_line) == (2, 7)


@pytest.mark.parametrize("value", ["[]", "{}", '{ "direct_import" : 1 }', "{ 1 }"])
def test_other_tool_information_has_no_effect(value: str) -> None:
    unit, findings = read_text(
        f'__tool_info__( "tecsgen" ) {value}\nconst int32_t A = 1;'
    )
    assert all(d.code.startswith("CDL02") for d in findings)
    assert [d.name for d in unit.declarations] == [("A",)] or findings


def test_a_file_of_tecscde_can_be_named(tmp_path: Path) -> None:
    (tmp_path / "one.cde").write_text("const int32_t A = 1;\n", encoding="utf-8")
    assert run(["inspect", "--no-cache", str(tmp_path / "one.cde")]) == 0
