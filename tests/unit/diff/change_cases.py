"""The table of changes: one case for each form of a kind, in `cases/*.toml`.

A case has definitions of an old and a new version (`old` and `new`: a text, or texts by file),
files of both (`both`), the code, what the change breaks, and the codes of further changes that
come with it (`also`).
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

from rtgen.diff.changes import Change
from rtgen.diff.compare import compare
from rtgen.diff.kinds.catalogue import KINDS
from rtgen.diff.reading import Source, opened

FOLDER = Path(__file__).parent / "cases"
TITLES = {kind.code: kind.title for kind in KINDS}
_LANGUAGES = {
    ".idl": "idl",
    ".cdl": "cdl",
    ".toml": "toml",
    ".eds": "ini",
    ".dcf": "ini",
    ".xml": "xml",
}


@dataclass(frozen=True)
class Case:
    """A row of the table."""

    code: str
    form: str
    breaks: str
    old: Mapping[str, str]
    new: Mapping[str, str]
    both: Mapping[str, str] = field(default_factory=dict)
    also: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The code with the form."""
        return f"{self.code} {self.form}"

    def changes(self, folder: Path) -> list[Change]:
        """What is found between the two versions, written below `folder`."""
        sources = []
        for label, files in (("old", self.old), ("new", self.new)):
            below = folder / label
            for name, text in {**self.both, **files}.items():
                path = below / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            sources.append(Source(label, below))
        with ExitStack() as stack:
            old, new = (stack.enter_context(opened(each)) for each in sources)
            return compare(old, new)


def cases() -> list[Case]:
    """All cases, by code."""
    found = []
    for path in sorted(FOLDER.glob("*.toml")):
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        file = content.get("file", "")
        for each in content["case"]:
            texts = {
                key: _texts(each.get(key, {}), file) for key in ("old", "new", "both")
            }
            found.append(
                Case(
                    each["code"],
                    each["form"],
                    each["breaks"],
                    texts["old"],
                    texts["new"],
                    texts["both"],
                    tuple(each.get("also", ())),
                )
            )
    return sorted(found, key=lambda case: case.code)


def _texts(value: str | dict[str, str], file: str) -> dict[str, str]:
    texts = {file: value} if isinstance(value, str) else value
    return {name: text.rstrip("\n") + "\n" for name, text in texts.items()}


def table() -> str:
    """The table of docs/diff.md."""
    rows = [
        f"| {case.code} | {TITLES[case.code]} | {case.form.replace('|', chr(92) + '|')} | "
        f"{case.breaks} |"
        for case in cases()
    ]
    head = ["| code | change | form | breaks |", "|---|---|---|---|"]
    return "\n".join([*head, *rows]) + "\n"


def page(code: str) -> str:
    """The page of `rtgen explain` for a kind: why, its first case, and what all forms break."""
    kind = next(k for k in KINDS if k.code == code)
    own = [case for case in cases() if case.code == code]
    lines = [*_wrapped(f"{kind.why[0].upper()}{kind.why[1:]}."), ""]
    for label, texts in (("before", own[0].old), ("after", own[0].new)):
        for name, text in texts.items():
            language = _LANGUAGES.get(Path(name).suffix, "text")
            lines += [f"{label.capitalize()}, in `{name}`:", "", f"```{language}"]
            lines += [*text.rstrip("\n").split("\n"), "```", ""]
    lines += ["What it breaks:", ""]
    lines += [f"- {case.form}: {case.breaks}" for case in own]
    return "\n".join(lines) + "\n"


def _wrapped(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, 98)
