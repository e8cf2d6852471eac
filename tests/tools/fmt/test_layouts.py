"""Random layouts: the formatter keeps every token and comment, and is idempotent."""

import pytest
from layouts import content, layout
from seeds import budget, cases

from rtgen import api
from rtgen.compiler.inspection.models import inspect
from rtgen.tools.fmt import edits, format_text
from rtgen.tools.fmt.tokens import Kind, Language, tokens

MILLION = 1_000_000
NUMBERS = cases(2_000)
if budget(1) > 1:
    NUMBERS = range(NUMBERS.start, NUMBERS.start + max(MILLION, len(NUMBERS)))
PARTS = 8 if len(NUMBERS) < MILLION else 64


@pytest.mark.sampled(2)
@pytest.mark.random
@pytest.mark.parametrize("part", range(PARTS))
def test_nothing_is_lost_and_a_second_run_changes_nothing(part: int) -> None:
    for number in NUMBERS[part::PARTS]:
        text, language = layout(number)
        form = format_text(text, language)
        assert content(form, language) == content(text, language), number
        assert format_text(form, language) == form, number
        assert not edits(form, language), number


@pytest.mark.random
def test_a_range_loses_nothing() -> None:
    for number in cases(200):
        text, language = layout(number)
        lines = text.count("\n") + 1
        first = number % lines + 1
        done, parts = 0, [""]
        for edit in edits(text, language, lines=(first, min(first + 3, lines))):
            parts += text[done : edit.start], edit.text
            done = edit.end
        changed = "".join([*parts, text[done:]])
        assert content(changed, language) == content(text, language), number


@pytest.mark.nightly
@pytest.mark.random
def test_documentation_stays_with_its_declaration() -> None:
    for number in cases(150):
        text, language = layout(number)
        if language is not Language.IDL:
            continue
        if any(t.kind is Kind.DIRECTIVE for t in tokens(text, language)):
            continue
        before, after = (api.read(t) for t in (text, format_text(text, language)))
        assert _places_aside(inspect(before.model, [])) == _places_aside(
            inspect(after.model, [])
        ), number
        codes = [d.code for d in before.diagnostics]
        assert sorted(codes) == sorted(d.code for d in after.diagnostics), number


def _places_aside(value: object) -> object:
    if isinstance(value, dict):
        return {k: _places_aside(v) for k, v in value.items() if k != "line"}
    if isinstance(value, list):
        return [_places_aside(item) for item in value]
    return value
