"""Predefined macros (ISO C 1998, 16.8)."""

from __future__ import annotations

import re
from collections.abc import Mapping

from rtgen.compiler.frontends.idl.text.macros import ExpansionError, Macro, define

PLACES = ("__FILE__", "__LINE__")
"""Macros that expand to the place where they are used."""

_TESTED_MACROS = {
    "__OMNIIDL__": "0x2630",
    "__RTGEN__": "1",
    "__STDC__": "1",
    "__STDC_VERSION__": "199409L",
    "__DATE__": '"Jan  1 1970"',
    "__TIME__": '"00:00:00"',
}
"""Macros that files test for; all except `__RTGEN__` and the times are those of omniidl 4.2.5."""
TIMES = {
    name: define(f"{name} {_TESTED_MACROS[name]}") for name in ("__DATE__", "__TIME__")
}
"""Macros for the time of translation, which is constant here."""


def predefined(values: Mapping[str, str]) -> dict[str, Macro]:
    """Return the macro table at the start of a translation unit: predefined macros and `values`.

    Raises ExpansionError for a name that is not an identifier.
    """
    table = {**_TESTED_MACROS, **values}
    macros = {}
    for name, value in table.items():
        if not re.fullmatch(r"[A-Za-z_]\w*", name):
            raise ExpansionError(f"'{name}' cannot be the name of a macro")
        macros[name] = define(f"{name} {value}")
    for name in PLACES:
        macros[name] = Macro(name, None, ())
    return macros
