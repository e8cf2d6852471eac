"""`rtgen fmt` of all definition files: model and comments are kept; a second run changes
nothing.
"""

import shutil
from pathlib import Path

import pytest

from rtgen import api
from rtgen.compiler.diagnostics import InputError, has_errors
from rtgen.compiler.inspection.models import inspect
from rtgen.tools.fmt.files import LANGUAGES, content, format_bytes
from rtgen.tools.fmt.tokens import COMMENTS, Kind, tokens

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("specs", "src", "tests")
WITHOUT_TOKENS = {
    "CDL0003_not_a_text_file",
    "CDL0100_character_that_is_not_allowed_here",
    "CDL0101_comment_that_is_never_closed",
    "CDL0102_string_that_is_never_closed",
    "IDL0004_character_that_is_not_allowed_here",
    "IDL0007_comment_that_is_never_closed",
    "IDL0108_string_that_is_never_closed",
    "full_width_marks",
    "open_string",
}
FILES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*")
    if path.suffix in LANGUAGES
    and not path.as_posix().startswith(f"{ROOT.as_posix()}/tests/golden/cases/FMT0001")
    and "CDL0012_" not in path.as_posix()
)
PARTS = 6


@pytest.mark.sampled(2)
@pytest.mark.parametrize("part", range(PARTS))
def test_tokens_and_comments_stay(part: int) -> None:
    for name in FILES[part::PARTS]:
        data = (ROOT / name).read_bytes()
        if Path(name).parent.name in WITHOUT_TOKENS:
            with pytest.raises(InputError, match="FMT0001"):
                format_bytes(data, name)
            continue
        form = format_bytes(data, name)
        assert format_bytes(form, name) == form, name
        assert kept(form, name) == kept(data, name), name


def kept(data: bytes, name: str) -> list[list[str]]:
    """Return the tokens, comments and preprocessor lines of a file, without white space."""
    language = LANGUAGES[Path(name).suffix]
    found = tokens(content(data, language).text, language)
    return [
        (
            [line.strip() for line in token.text.split("\n")]
            if token.kind in (*COMMENTS, Kind.DIRECTIVE)
            else [token.text.replace("@ ", "@")]
        )
        for token in found
    ]


READABLE = [
    name for name in FILES if "_errors/" not in name and "generated/" not in name
]


@pytest.mark.nightly
@pytest.mark.parametrize("part", range(PARTS))
def test_the_model_stays(
    part: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in {Path(name).parts[0] for name in READABLE}:
        definitions = shutil.ignore_patterns(
            "*.py", "*.json", "__pycache__", "expected", "cdl_errors"
        )
        shutil.copytree(ROOT / name, tmp_path / name, ignore=definitions)
    monkeypatch.chdir(tmp_path)
    names = [name for name in READABLE if "/expected/" not in name][part::PARTS]
    before = {name: model(name) for name in names}
    assert sum(each is not None for each in before.values()) > len(names) // 2
    for name in names:
        path = Path(name)
        path.write_bytes(format_bytes(path.read_bytes(), name))
    for name in names:
        if before[name] is not None:
            assert model(name) == before[name], name


def model(name: str) -> object:
    """Return the output of `inspect --json` without positions; None for a file with errors."""
    result = api.read([name], include=["specs/idl", str(Path(name).parent)])
    if has_errors(result.diagnostics):
        return None
    return _places_aside(inspect(result.model, []))


def _places_aside(value: object) -> object:
    if isinstance(value, dict):
        return {k: _places_aside(v) for k, v in value.items() if k != "line"}
    if isinstance(value, list):
        return [_places_aside(item) for item in value]
    return value
