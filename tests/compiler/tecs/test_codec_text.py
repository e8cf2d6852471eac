"""Generated codecs and types of random signatures: black's form, and type checks."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from random import Random

import black
import pytest
from random_signatures import sample
from type_checkers import check_by_mypy, check_by_pyright

from rtgen.compiler.backends.tecs.codec import codec_text
from rtgen.compiler.backends.tecs.types_module import types_text
from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.model.tecs import Signature, TecsUnit

CLASHES = """
const int32_t Final = 3; const char_t *const TEXT = "a\\tb"; const double64_t RATE = 0.5;
struct tagBox { uint8_t _int; };
struct Text { int8_t list; struct tagBox box; struct tagBox field[2]; };
typedef struct Text ByteBudget;
signature sOne {
  ER f( [in] ByteBudget Text, [in,size_is(len)] const struct tagBox *tagBox, [in] uint8_t len,
        [out] int8_t *returned, [inout] int32_t *self );
  ER g( [in,size_is((number > 3 ? 1 : 0) + (number != 3 || number >= 9 ? 5 : 2))] const int8_t *v,
        [in,size_is(((number + 1) / 2) * ((number + 3) % 4) + ((number - 1) * (number - 2)))]
        const struct tagBox *boxes, [in,string(number * 2 > 10 ? 10 : number * 2)]
        const char_t *text, [in] int16_t number );
  void a_function_with_a_name_that_is_long_enough_to_break_lines_wherever_it_stands_here(
        [in] int32_t a_parameter_with_a_name_that_is_long_enough_to_break_lines_as_well,
        [out] int64_t *another_parameter_with_a_name_that_is_long_enough_to_break_lines );
};
"""


def modules(unit: TecsUnit, signature: Signature) -> dict[str, str]:
    header = "# A header.\n"
    return {
        "__init__.py": "",
        "one_codec.py": codec_text(unit, signature, header),
        "_types.py": types_text(unit, [layout_of(unit, signature)], header),
    }


def packages() -> Iterator[tuple[str, dict[str, str]]]:
    unit, _ = read_text(CLASHES)
    signature = next(d for d in unit.declarations if isinstance(d, Signature))
    yield "clashes", modules(unit, signature)
    unit, _ = read_text("signature sOne {};")
    signature = next(d for d in unit.declarations if isinstance(d, Signature))
    yield "empty", modules(unit, signature)
    for seed in range(12):
        found = sample(Random(seed), functions=4)
        yield f"random{seed}", modules(found.unit, found.signature)


@pytest.mark.nightly
@pytest.mark.peer
def test_text_is_in_the_form_of_black() -> None:
    for name, files in packages():
        for file, text in files.items():
            assert black.format_str(text, mode=black.Mode()) == text, (name, file)


def test_a_file_without_structs_and_constants_has_an_empty_module() -> None:
    unit, _ = read_text("signature sOne { void f( void ); };")
    signature = unit.declarations[-1]
    assert isinstance(signature, Signature)
    text = modules(unit, signature)["_types.py"]
    assert text.endswith('.cdl."""\n\nfrom __future__ import annotations\n')


@pytest.mark.nightly
@pytest.mark.slow
@pytest.mark.parametrize(
    "checker", ["mypy", pytest.param("pyright", marks=pytest.mark.nightly)]
)
def test_type_checkers_find_nothing(tmp_path: Path, checker: str) -> None:
    made = tmp_path / "made"
    for name, files in packages():
        for file, text in files.items():
            path = made / name / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
    if checker == "mypy":
        check_by_mypy([made], [tmp_path])
    else:
        check_by_pyright([made], tmp_path)
