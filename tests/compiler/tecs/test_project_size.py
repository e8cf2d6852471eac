"""A project of many joins stays small: the common parts of signatures are generated once."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
from boards import emit, write

from rtgen.compiler.frontends.cdl import read_text
from rtgen.compiler.kit.limits import MAX_LEVELS
from rtgen.compiler.layouts.tdr import TransferError
from rtgen.compiler.layouts.tdr_messages import layout_of
from rtgen.compiler.model.tecs import Signature

ROOT = Path(__file__).parents[3]

sys.path.append(str(ROOT / "benchmarks"))  # whose scripts import each other


def _project(joins: int, functions: int) -> str:
    place = ROOT / "benchmarks" / "tecs_project.py"
    spec = importlib.util.spec_from_file_location("tecs_project", place)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text: str = module.project(joins, functions)
    return text


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("big")
    emission, _ = emit(folder, {"big.cdl": _project(20, 20)})
    write(folder, emission.artifacts)
    return folder


def test_lines_of_python(tree: Path) -> None:
    files = list((tree / "robots" / "tecs").rglob("*.py"))
    lines = sum(file.read_text("utf-8").count("\n") for file in files)
    assert lines <= 27 * 20 * 20
    assert not list(tree.rglob("*_calls.py")), "no definition uses calls over CORBA"


def test_one_marshaller_imports_one_signature(tree: Path) -> None:
    code = (
        "import sys, robots.tecs.big.big7_marshaller\n"
        "print(*(m for m in sys.modules if m.startswith('robots.tecs.big.')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tree,
        capture_output=True,
        text=True,
        check=True,
    )
    modules = done.stdout.split()
    assert "robots.tecs.big.big7_codec" in modules
    assert not [m for m in modules if "big8" in m]


def test_only_the_order_of_replies_that_was_chosen(tree: Path) -> None:
    text = (tree / "robots" / "tecs" / "big" / "_messages.py").read_text("utf-8")
    assert text.count("def encode_reply") == text.count("def encode_request") == 6
    assert "`ER ([in, size_is(n)] const int16_t *v, [in] int32_t n)`" in text


def test_structs_hold_each_other_for_a_limited_number_of_levels() -> None:
    text = "struct tag0 { int8_t a; };\n"
    for level in range(1, MAX_LEVELS + 1):
        text += f"struct tag{level} {{ struct tag{level - 1} a; }};\n"
    signature = "signature sOne {{ ER f([in] struct tag{} a); }};"
    unit, _ = read_text(text + signature.format(MAX_LEVELS - 1))
    made = unit.declarations[-1]
    assert isinstance(made, Signature)
    assert len(layout_of(unit, made).records) == MAX_LEVELS
    unit, _ = read_text(text + signature.format(MAX_LEVELS))
    made = unit.declarations[-1]
    assert isinstance(made, Signature)
    with pytest.raises(TransferError) as caught:
        layout_of(unit, made)
    assert caught.value.reason == (
        f"structs that hold each other for more than {MAX_LEVELS} levels"
    )
    assert caught.value.span.line == 2, "where the struct is that is one too many"
