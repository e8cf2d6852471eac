"""Bodies of calls with equal members are written as if each were rendered by itself."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from seeds import cases

from rtgen.compiler.backends import Artifact, Options
from rtgen.compiler.backends.kit import rendering
from rtgen.compiler.backends.types.backend import BACKEND
from rtgen.compiler.frontends.idl import load

TYPES = (
    *("long", "double", "string", "any", "octet", "sequence<double, 4>", "wstring<9>"),
    *("Mode", "Record", "Object", "unsigned long long", "Values", "Other"),
)
NAMES = ("a", "class", "value", "to_cdr", "self", "text_" * 8 + "x", "idl", "ClassVar")


def _interface(draw: random.Random, number: int) -> str:
    """Return an interface; few parameters, so that some have equal shapes."""
    lines = [f"  interface Service{'Long' * draw.choice((0, 0, 9))}{number} {{"]
    for operation in range(draw.choice((1, 3, 12))):
        parameters = [
            f"{draw.choice(('in', 'out', 'inout'))} {draw.choice(TYPES)} {name}"
            for name in draw.sample(NAMES, draw.randint(0, 2))
        ]
        result = draw.choice(("void", *TYPES))
        name = f"call{'_of_a_long_name' * draw.choice((0, 0, 4))}{operation}"
        raised = draw.choice(("", " raises (Failed)"))
        lines.append(f"    {result} {name}({', '.join(parameters)}){raised};")
    if draw.random() < 0.5:
        lines.append(f"    attribute {draw.choice(TYPES)} gain;")
    return "\n".join([*lines, "  };"])


def _definitions(draw: random.Random) -> str:
    interfaces = "\n".join(_interface(draw, number) for number in range(6))
    return f"""\
module Lab {{
  enum Mode {{ OFF, ON }};
  typedef sequence<long> Values;
  struct Record {{ long x; string text; }};
  exception Failed {{ string reason; Mode mode; }};
  interface Other {{ void ping(); }};
{interfaces}
}};
"""


@pytest.mark.sampled(8)
@pytest.mark.random
@pytest.mark.parametrize("number", cases(60))
@pytest.mark.parametrize("representation", ["cdr", "xcdr2"])
def test_they_are_equal(tmp_path: Path, number: int, representation: str) -> None:
    file = tmp_path / "services.idl"
    file.write_text(_definitions(random.Random(number)))
    model = load([file], root=tmp_path).model
    options = Options(
        "lab", "nodes", "1", representation=representation, extensibility="appendable"
    )

    def written() -> tuple[Artifact, ...]:
        emission = BACKEND.emit(model, options)
        assert not emission.diagnostics
        return tuple(emission.artifacts)

    by_shape = written()
    renderer = rendering.RENDERER.set(rendering.render_original)
    try:
        assert not rendering.are_original()
        one_by_one = written()
    finally:
        rendering.RENDERER.reset(renderer)
    assert any(
        "class Lab_Service" in each.text or "_request" in each.text for each in by_shape
    )
    assert by_shape == one_by_one
