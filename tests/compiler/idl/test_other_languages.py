"""Files in other languages named IDL: one finding each, if there is clear evidence."""

from pathlib import Path

import pytest
from mistakes import MISTAKES

from rtgen.compiler.frontends.idl import load
from rtgen.compiler.frontends.idl.syntax.other_languages import other_language

FOREIGN = {
    "Microsoft's library": (
        "Microsoft",
        'import "oaidl.idl";\n[ uuid(1-2), version(1.0) ]\nlibrary ArmLib { importlib("a.tlb"); };',
    ),
    "Microsoft's interface": (
        "Microsoft",
        "#include <unknwn.h>\n[object, pointer_default(unique)]\n"
        "interface IArm : IUnknown { HRESULT Move([in] DWORD a, [out, retval] BSTR *b); };",
    ),
    "Microsoft's quotes": (
        "Microsoft",
        'cpp_quote("#define A 1")\nstruct S { DWORD a; };',
    ),
    "DCE's operations": (
        "DCE",
        "interface arm { void move([in] long a, [out] long *b); void stop([in] handle_t h); };",
    ),
    "DCE's arrays": ("DCE", "typedef struct { long n; [size_is(n)] long *a; } seq;"),
    "dictionary": ("Web IDL", 'dictionary Init : Base { DOMString name = ""; };'),
    "partial": ("Web IDL", "partial interface Window { attribute any robot; };"),
    "attributes": (
        "Web IDL",
        "[Exposed=(Window,Worker), SecureContext]\ninterface Arm {};",
    ),
    "promise": ("Web IDL", "interface Arm { Promise<long> move(double angle); };"),
    "callback": ("Web IDL", "callback Done = undefined (long a);"),
    "published": ("UNO", "published interface XArm { void move([in] long a); };"),
    "UNO's module": (
        "UNO",
        "module com { module sun { module star { module arm { service Arm: XArm; }; }; }; };",
    ),
    "singleton": ("UNO", "module m { singleton theArm : XArm; };"),
    "scriptable": (
        "XPIDL",
        '#include "nsISupports.idl"\n[scriptable, uuid(a-b)]\n'
        "interface nsIArm : nsISupports { void move(in AString a); };",
    ),
    "raw code": ("XPIDL", '%{C++\n#include "a.h"\n%}\ninterface nsIArm {};'),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_one_finding(name: str, tmp_path: Path) -> None:
    language, text = FOREIGN[name]
    path = tmp_path / "input.idl"
    path.write_text(text)
    [found] = load([path], root=tmp_path).diagnostics
    assert found.code == "IDL0126"
    assert language in found.message
    assert found.span is not None


def test_a_file_that_includes_it_has_no_finding_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "arm.idl").write_text(FOREIGN["dictionary"][1])
    path = tmp_path / "input.idl"
    path.write_text('#include "arm.idl"\nstruct S { Init a; };\n')
    [found] = load([path], root=tmp_path).diagnostics
    assert (found.code, Path(found.span.file).name if found.span else "") == (
        "IDL0126",
        "arm.idl",
    )


@pytest.mark.parametrize(
    "text",
    [
        "const long ref = 2; struct S { long a[ref], b[3][ref]; };",
        "struct dictionary { long partial; }; struct published { dictionary singleton_; };",
        'const string A = "[uuid(1)] cpp_quote(1)";',
        "interface service { void includes(); };",
    ],
)
def test_words_of_other_languages_are_names(text: str, tmp_path: Path) -> None:
    path = tmp_path / "input.idl"
    path.write_text(text)
    assert load([path], root=tmp_path).diagnostics == ()
    assert other_language(text) is None


def test_a_mistake_does_not_make_it_another_language() -> None:
    texts = [text.replace("§", "") for text, _, _ in MISTAKES.values()]
    assert [text for text in texts if other_language(text)] == []


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "piece", ["[a, ", "; [in", 'import "a"; ', "typedef (a ", "{ [", "dictionary a "]
)
def test_long_texts_take_no_time(piece: str) -> None:
    assert other_language(piece * 20_000) is None
