"""C headers: the typedefs and struct tags that `import_C` takes from them."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.model.tecs import TecsDeclaration


@dataclass(frozen=True, slots=True)
class Header:
    """What a C header declares, in order."""

    declarations: tuple[TecsDeclaration, ...]
