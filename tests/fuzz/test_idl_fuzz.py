"""The IDL front end takes anything: whatever the text, it gives coded findings in bounded time."""

import random
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rtgen.diagnostics import has_errors
from rtgen.frontends import FrontendResult
from rtgen.frontends.idl import load

ROOT = Path(__file__).parents[2]
SEEDS = sorted((ROOT / "tests/golden/idl").glob("*.idl"))
PIECES = [
    *(
        "module",
        "struct",
        "union",
        "switch",
        "case",
        "default",
        "enum",
        "interface",
        "typedef",
    ),
    *(
        "const",
        "sequence",
        "string",
        "long",
        "unsigned",
        "double",
        "void",
        "in",
        "out",
        "raises",
    ),
    *(
        "attribute",
        "readonly",
        "oneway",
        "exception",
        "valuetype",
        "component",
        "consumes",
    ),
    *(
        "provides",
        "uses",
        "map",
        "bitset",
        "bitmask",
        "bitfield",
        "import",
        "typeid",
        "any",
    ),
    *(
        "A",
        "B",
        "a",
        "_struct",
        "__x",
        "ü",
        "1",
        "0x1F",
        "089",
        "1.5",
        ".5e3",
        "12d",
        "1.0f",
    ),
    *(
        '"text"',
        "'c'",
        'L"w"',
        '"open',
        "'",
        "/*",
        "*/",
        "//",
        "{",
        "}",
        "(",
        ")",
        "[",
        "]",
    ),
    *(
        "<",
        ">",
        ">>",
        "<<",
        ",",
        ";",
        ":",
        "::",
        "=",
        "|",
        "^",
        "&",
        "+",
        "-",
        "*",
        "/",
        "%",
    ),
    *("~", "@key", "@default(1)", "@", "#", "\\", "\n", "\n#define A B\n", "\n#if 1\n"),
    *("\n#endif\n", "\n#else\n", '\n#include "input.idl"\n', '\n#pragma prefix "x"\n'),
    *(
        '\n#pragma ID A "IDL:A:1.0"\n',
        '\n# 12 "file" 1\n',
        "\n#define F(x) x x\n",
        "F(",
        "\t",
    ),
]
BOUNDED = settings(
    max_examples=120,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


def read(folder: Path, data: bytes) -> FrontendResult:
    path = folder / "input.idl"
    path.write_bytes(data)
    result = load([path], root=folder, include=[ROOT / "tests/golden/idl"])
    for diagnostic in result.diagnostics:
        assert diagnostic.code.startswith("IDL")
        assert diagnostic.message
        assert diagnostic.span is not None
        assert diagnostic.span.line >= 1
        assert diagnostic.span.column >= 1
    return result


@BOUNDED
@given(st.lists(st.sampled_from(PIECES), max_size=60))
def test_any_words(tmp_path: Path, words: list[str]) -> None:
    read(tmp_path, " ".join(words).encode())


@BOUNDED
@given(st.binary(max_size=300))
def test_any_bytes(tmp_path: Path, data: bytes) -> None:
    read(tmp_path, data)


@BOUNDED
@given(st.text(max_size=200))
def test_any_text(tmp_path: Path, text: str) -> None:
    read(tmp_path, text.encode("utf-8", "surrogatepass"))


@pytest.mark.parametrize("seed", SEEDS, ids=lambda path: path.stem)
def test_mutations(seed: Path, tmp_path: Path) -> None:
    """Words removed, repeated, exchanged and put in, a few at a time."""
    chance = random.Random(seed.stem)
    words = seed.read_text(encoding="utf-8").split(" ")
    for _ in range(25):
        mutant = list(words)
        for _ in range(chance.randint(1, 4)):
            place = chance.randrange(len(mutant))
            match chance.randrange(4):
                case 0:
                    del mutant[place]
                case 1:
                    mutant.insert(place, mutant[place])
                case 2:
                    mutant.insert(place, chance.choice(PIECES))
                case _:
                    other = chance.randrange(len(mutant))
                    mutant[place], mutant[other] = mutant[other], mutant[place]
        read(tmp_path, " ".join(mutant).encode())


@pytest.mark.parametrize(
    "text",
    [
        "const long A = " + "(" * 5000 + "1" + ")" * 5000 + ";",
        "typedef " + "sequence<" * 2000 + "long" + ">" * 2000 + " A;",
        "module m {" * 1000,
        "".join(f"module m{n} {{" for n in range(1000)) + "};" * 1000,
        "".join(f"struct s{n} {{" for n in range(500)) + "long a;" + "} b;" * 500,
        "#if " + "(" * 1000 + "1" + ")" * 1000 + "\n#endif",
        "x" * 10_000_000,
        "struct S { long a; }; " * 600_000,
        '"\n' * 2000,
        "}" * 2000,
        "@" * 2000,
        '#include "input.idl"\n' * 3,
        "#define A0 1\n"
        + "".join(f"#define A{n + 1} A{n} A{n}\n" for n in range(40))
        + "A40",
        "const unsigned long A = 1 << 99999999999;",
        "struct S { long { long a; };",
        'module A {\n#include "input.idl"\n',
        "struct A; struct T { A struct A; struct T { A ::s_; };",
        "typedef long T; typedef T T; typedef T U[2];",
    ],
    ids=lambda text: text[:24].strip(),
)
def test_extremes_end_in_findings(text: str, tmp_path: Path) -> None:
    assert has_errors(read(tmp_path, text.encode()).diagnostics)
