"""The constants of a module that hold the layouts of its codecs."""

from __future__ import annotations

from rtgen.backends.types.scope import Scope
from rtgen.layouts.cdr import Records, Run


class Layouts:
    """The layouts that a codec needs, each a constant of the module, in order of first use."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._numbers: dict[int, int] = {}
        self._kept: list[Run | Records] = []

    def of(self, part: Run | Records) -> str:
        """The constant of a run or of the elements of a sequence."""
        number = self._number(part)
        return f"_{self._name}_layout" + (f"_{number}" if number > 1 else "")

    def variable(self, kind: str, part: Run | Records) -> str:
        """A variable for something of it."""
        return f"{kind}_{self._number(part)}"

    def lines(self, scope: Scope, whole: bool) -> list[str]:
        """The definitions. `whole`: the first is a run that makes up the whole value."""
        lines = []
        for part in self._kept:
            if isinstance(part, Records):
                lines.append(f'{self.of(part)} = {scope.Fixed}("{part.format}")')
                continue
            texts = ", ".join(f'"{section.text}"' for section in part.sections)
            settled = all(section.settled for section in part.sections)
            kind = scope.Layout if part.known else scope.PhasedLayout
            if settled and whole and len(part.sections) == 1:
                kind, texts = scope.Fixed, f'"{part.sections[0].text[1:]}"'
            elif settled:
                kind = scope.Settled
            lines.append(f"{self.of(part)} = {kind}({texts})")
        return lines

    def _number(self, part: Run | Records) -> int:
        if id(part) not in self._numbers:
            self._kept.append(part)
            self._numbers[id(part)] = len(self._kept)
        return self._numbers[id(part)]
