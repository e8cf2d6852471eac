"""Units that several files begin with: what they declare is made once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rtgen.compiler.frontends.idl.text.predefined import predefined
from rtgen.compiler.frontends.idl.text.source import Library, Source
from rtgen.compiler.frontends.idl.translation import Translation, Translator

HEADER = """
module M {
  interface Later;
  const long N = 3;
  typedef sequence<double, N> Row;
  @final struct S { Row row; @key long id; };
  exception E { string<N> why; };
  component Base { attribute long gain; };
};
"""
HEAD = '#include "header.idl"\n'
FILES = {
    "plain.idl": HEAD + "struct A { M::S s; };",
    "twice.idl": HEAD + '#include "header.idl"\nstruct B { M::S s; };',
    "derived.idl": HEAD + "component D : M::Base { attribute long more; };",
    "typedef.idl": HEAD + "typedef M::Row Rows[N];\nconst long N = M::N;",
    "defines_later.idl": HEAD + "module M { interface Later { void go(); }; };",
    "other_ids.idl": HEAD + '#pragma ID M::S "IDL:other/S:1.0"\nstruct C { M::S s; };',
    "own_before.idl": "module M { struct Own { long a; }; };\n"
    + HEAD
    + "struct F { M::S s; };",
    "pragma_before.idl": '#pragma prefix "acme.com"\n#include "header.idl"\nstruct G { M::S s; };',
    "macro.idl": '#define Row Line\n#include "header.idl"\nstruct H { M::Line line; };',
    "same_name.idl": HEAD + "module M { struct S { long other; }; };",
    "same_id.idl": HEAD + '#pragma ID M::E "IDL:M/S:1.0"\nstruct J { M::S s; };',
    "other_header.idl": '#include "other.idl"\n#include "header.idl"\nstruct K { M::S s; O o; };',
    "annotated.idl": HEAD
    + "@annotation final { long x default 1; };\nstruct L { M::S s; };",
    "wrong.idl": HEAD + "struct W { M::Unknown u; string<M::N - 3> t; };",
}
WITH_FINDINGS = HEADER.replace("long id;", "long id; @unknown_one long x; fixed bad;")


def _translator(folder: Path) -> Callable[[Path], Translation]:
    library = Library(folder, [], {}, {}, "auto", None)
    translator = Translator(library, ignore_case_clashes=False)

    def translate(path: Path) -> Translation:
        source = library.open(path)
        assert isinstance(source, Source)
        return translator.translate(source, predefined({}), virtual=False)

    return translate


@pytest.mark.parametrize("header", [HEADER, WITH_FINDINGS], ids=["clean", "findings"])
@pytest.mark.parametrize("names", [[*FILES], [*FILES][::-1]], ids=["so", "turned"])
def test_a_unit_read_after_others_is_as_alone(
    tmp_path: Path, header: str, names: list[str]
) -> None:
    (tmp_path / "header.idl").write_text(header)
    (tmp_path / "other.idl").write_text("struct O { octet o; };")
    after_others = _translator(tmp_path)
    for name in names:
        path = tmp_path / name
        path.write_text(FILES[name])
        alone, shared = _translator(tmp_path)(path), after_others(path)
        assert shared.declarations == alone.declarations, name
        assert shared.findings == alone.findings, name


def test_what_several_units_begin_with_is_made_once(tmp_path: Path) -> None:
    (tmp_path / "header.idl").write_text(HEADER)
    translate = _translator(tmp_path)
    made = []
    for name in ("plain.idl", "derived.idl"):
        path = tmp_path / name
        path.write_text(FILES[name])
        made.append(translate(path).declarations)
    first, second = made
    assert all(second[name] is first[name] for name in first if name[0] == "M")
