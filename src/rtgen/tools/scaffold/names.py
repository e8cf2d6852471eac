"""Names for the parts of a starter, in their forms."""

from __future__ import annotations

import builtins
import keyword
import re
from collections.abc import Collection
from dataclasses import dataclass, replace

from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.typemap.idl_keywords import escaped
from rtgen.compiler.typemap.python.names import module_name, snake_case
from rtgen.facts import python_modules
from rtgen.facts.file_names import is_device
from rtgen.ros2.rosidl.syntax import PACKAGE_NAME
from rtgen.tools.scaffold.rules import UNUSABLE_NAME

MAX_LENGTH = 64
_FORM = re.compile(r"[A-Za-z][A-Za-z0-9]*([_-][A-Za-z0-9]+)*")
_RESERVED = frozenset({"components", "generated", "rtc", "tecs"})
_FORM_HINT = "use ASCII letters, digits, '_' and '-', beginning with a letter"
_ROS_HINT = (
    "use lower-case letters, digits and single '_', two at least, a letter first"
)
_OTHER_HINT = "choose another name"


@dataclass(frozen=True, slots=True)
class Names:
    """A name as given, as a class (`LeftDrive`) and as a module (`left_drive`)."""

    given: str
    type: str
    module: str


def names(text: str, *, inner: bool = False) -> Names:
    """Return the forms of a name; an `inner` one is that of a package in another one.

    Raises InputError for one that is invalid in a language.
    """
    if not _FORM.fullmatch(text):
        form = "is not a name that files, IDL and Python can have"
        raise _unusable(text, form, _FORM_HINT)
    fault = _fault(text, inner)
    if fault is not None:
        raise _unusable(text, fault)
    return _forms(text)


def project_names(text: str) -> tuple[str, Names]:
    """Return the package of a project `acme.rover`, and the forms of its last part.

    Raises InputError as `names` does.
    """
    first, *inner = text.split(".")
    parts = [names(first), *(names(part, inner=True) for part in inner)]
    package = ".".join(part.module for part in parts)
    return package, replace(parts[-1], given=text)


def ros_package_name(text: str, taken: Collection[str]) -> None:
    """Raise InputError for a name that no package of ROS 2 can have (REP 144), or that is `taken`.

    The package has a Python package of this name.
    """
    words = re.sub(r"[^a-z0-9]+", "_", snake_case(text).lower()).strip("_")
    near = words.lstrip("0123456789_")
    fits = len(near) > 1 and near != text
    hint = f"did you mean {near}?" if fits else _OTHER_HINT
    if not PACKAGE_NAME.fullmatch(text) or len(text) < 2:
        fault = "is not a name of a package of ROS 2 (REP 144)"
        raise _unusable(text, fault, hint if fits else _ROS_HINT)
    if len(text) > MAX_LENGTH:
        raise _unusable(text, f"is longer than {MAX_LENGTH} characters")
    if keyword.iskeyword(text):
        raise _unusable(text, "is a keyword of Python")
    if owner := python_modules.owner(text):
        raise _unusable(text, f"is a module of {owner}, which it would hide")
    if text in taken:
        fault = "is another package that the systems need"
        raise _unusable(text, fault, f"for example {text}_systems")


def require_free(name: Names, used: Collection[str]) -> None:
    """Raise InputError for a class that is one of those `used` by the files with its name."""
    if name.type in used:
        raise _unusable(name.given, "is a class that the new test imports")


def _unusable(text: str, fault: str, hint: str = _OTHER_HINT) -> InputError:
    return InputError([UNUSABLE_NAME.at(None, f"{text!r} {fault}", hint=hint)])


def _forms(text: str) -> Names:
    words = re.split("[_-]", text)
    type_ = "".join(word[:1].upper() + word[1:] for word in words)
    return Names(text, type_, module_name("_".join(words)))


def _fault(text: str, inner: bool) -> str | None:
    if len(text) > MAX_LENGTH:
        return f"is longer than {MAX_LENGTH} characters"
    forms = _forms(text)
    if keyword.iskeyword(forms.module.rstrip("_")) or hasattr(builtins, forms.type):
        return "is a keyword or a built-in name of Python"
    if escaped(forms.type) != forms.type or escaped(text) != text:
        return "is a keyword of IDL"
    owner = None if inner else python_modules.owner(forms.module)
    if owner:
        return f"is a module of {owner}, which it would hide"
    if is_device(forms.module.rstrip("_")):
        return "is a device of Windows, and no file can be called so there"
    if forms.module in _RESERVED:
        return "is a package that rtgen generates"
    return None
