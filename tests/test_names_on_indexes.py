"""No text, script, hint or workflow installs rtgen by its name, which anyone could take.

Until it is published it comes from a clone, by a path, or from git, by an address.
"""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
_COMMAND = re.compile(
    r"\b(?:(?:pip3?|pipx|conda|mamba|poetry|pdm|rye|hatch|pipenv|uv)\b[^\n`]*?"
    r"\b(?:install|add|run|inject|sync)|uvx)\b(?P<words>[^\n`|&;<>]*)"
)
"""A command that installs, with its arguments."""
_NAME = re.compile(
    r"rtgen(?:[-_.](?:runtime|speed))?(?:\[[\w, -]*\])?\s*(?:[=<>!~]=?.*)?",
    re.IGNORECASE,
)
_REQUIRED = re.compile(
    r"""["'](rtgen(?:-runtime|-speed)?(?:\[[\w, -]*\])?(?:[=<>!~]=?[^"']*)?)["']"""
)
"""A requirement in a list of a TOML, YAML or Python file."""
_LISTS = re.compile(
    r"(?:dependencies|requires|install_requires|deps|packages)\s*[=:]\s*"
    r"""\[((?:[^\]"']|"[^"]*"|'[^']*')*)\]"""
)
_LINE = re.compile(rf"^\s*(?:-\s+)?{_NAME.pattern}\s*$", re.MULTILINE)
OWN = {"pyproject.toml": {"rtgen-runtime=="}}
"""rtgen requires the runtime, which a clone installs by the same command."""


def installed(text: str) -> list[str]:
    """Return the words by which commands in a text would install rtgen from an index."""
    words: list[str] = []
    for match in _COMMAND.finditer(text.replace("\\\n", " ")):
        arguments = re.split(r" in an? | #", match["words"])[0]
        try:
            each = shlex.split(arguments.replace("\\'", "'").replace('\\"', '"'))
        except ValueError:
            each = [word.strip("\"'") for word in arguments.split()]
        words += [w for w in (e.strip(".,;:()'\"") for e in each) if _NAME.fullmatch(w)]
    return words


def required(text: str) -> list[str]:
    """Return the requirements of lists in a text that name rtgen without an address."""
    return [
        each for entries in _LISTS.findall(text) for each in _REQUIRED.findall(entries)
    ]


def texts() -> dict[str, str]:
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True, text=True
    )
    found = {}
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if name != f"tests/{Path(__file__).name}" and path.is_file():
            data = path.read_bytes()
            if b"rtgen" in data and b"\0" not in data:
                found[name] = data.decode(errors="replace")
    return found


def test_nothing_is_installed_by_a_bare_name() -> None:
    every = texts()
    assert len(every) > 1000
    assert {
        name: each for name, text in every.items() if (each := installed(text))
    } == {}


def test_nothing_is_required_by_a_bare_name() -> None:
    wrong = {}
    for name, text in texts().items():
        own = OWN.get(name, set())
        found = [r for r in required(text) if not any(r.startswith(o) for o in own)]
        if Path(name).name.startswith("requirements") or "/requirements/" in f"/{name}":
            found += [line.strip() for line in _LINE.findall(text)]
        if found:
            wrong[name] = found
    assert wrong == {}


@pytest.mark.parametrize(
    "line",
    [
        "pip install rtgen",
        "pip install rtgen-speed",
        "python -m pip install --upgrade rtgen",
        "pip install 'rtgen[plot]'",
        'pip install "rtgen[plot,can]==0.2.0"',
        "hint=\"pip install 'rtgen[ui]'\"",
        "run `pip install rtgen-runtime`.",
        "uv pip install rtgen",
        "uv tool install rtgen",
        "uvx rtgen",
        "pipx run rtgen",
        "- run: pip install black rtgen",
        "RUN pip install --no-cache-dir \\\n    rtgen_runtime",
        "poetry add rtgen",
    ],
)
def test_such_a_command_would_be_seen(line: str) -> None:
    assert installed(line)


@pytest.mark.parametrize(
    "line",
    [
        "pip install ./runtime '.[plot]'",
        "pip install ./runtime . # rtgen",
        'pip install "rtgen @ git+https://example.org/rtgen@main"',
        "pip install -e .",
        "rtgen can hub",
        "pip uninstall rtgen",
    ],
)
def test_others_would_not(line: str) -> None:
    assert installed(line) == []


def test_requirements_would_be_seen() -> None:
    assert required('dependencies = ["click", "rtgen-runtime"]') == ["rtgen-runtime"]
    assert required("additional_dependencies: ['rtgen[can]']") == ["rtgen[can]"]
    assert required('dependencies = ["rtgen @ git+https://example.org/rtgen"]') == []
