"""Names and types of IDL in ROS 2 interface files."""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Container, Mapping
from typing import Final, NamedTuple

from rtgen.compiler.model import (
    ArrayType,
    Enum,
    Model,
    NamedType,
    PrimitiveType,
    ScopedName,
    SequenceType,
    StringType,
    Struct,
    Type,
)
from rtgen.compiler.typemap.python.names import snake_case
from rtgen.facts.primitives import Primitive
from rtgen.facts.ros import is_interface
from rtgen.ros2.rosidl.syntax import PRIMITIVES

_NAMES: Final[Mapping[str, str]] = {
    **{kind: name for name, kind in PRIMITIVES.items() if name != "char"},
    Primitive.CHAR: "char",
}
_INEXACT: Final = (Primitive.CHAR,)
"""Types that become others, which have another hash."""
_GLOBAL: Final = "interfaces"
"""The package of declarations in the global scope."""
_WORDS: Final = """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t
    char32_t class compl concept const consteval constexpr constinit const_cast continue
    co_await co_return co_yield decltype default delete do double dynamic_cast else enum
    explicit export extern false float for friend goto if inline int long mutable namespace new
    noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast requires restrict return short signed sizeof static static_assert
    static_cast struct switch template this thread_local throw true try typedef typeid typename
    union unsigned using virtual void volatile wchar_t while xor xor_eq linux unix
"""
"""Words of C (ISO/IEC 9899:2018, 6.4.1) and C++ (ISO/IEC 14882:2020, 5.11), and macros of GCC."""
_KEYWORDS: Final = frozenset(_WORDS.split())


class InexpressibleError(Exception):
    """ROS 2 cannot express a part of a declaration; the message names it."""


def package_name(scope: ScopedName) -> str:
    """Return the package of a module: `Lab::Arm` is `lab_arm`."""
    return _words("_".join(map(snake_case, scope))) or _GLOBAL


def message_name(name: str) -> str:
    """Return the message of a struct: `path_point` is `PathPoint`."""
    words = (word for word in re.split(r"_+", name) if word)
    return "".join(word[0].upper() + word[1:] for word in words)


def field_name(name: str) -> str:
    """Return the field of a member: `minAngle` is `min_angle`."""
    return _words(snake_case(name))


def _words(text: str) -> str:
    return re.sub(r"_+", "_", text.lower()).strip("_")


def reference(name: ScopedName) -> str:
    """Return the name of a message in a field."""
    if is_interface(name):
        return f"{name[0]}/{name[2]}"
    return f"{package_name(name[:-1])}/{message_name(name[-1])}"


def package_of(name: ScopedName) -> str:
    """Return the package of a message."""
    return name[0] if is_interface(name) else package_name(name[:-1])


def is_reserved(name: str) -> bool:
    """Return whether a field of this name is not compiled, as rosidl generates C, C++, Python."""
    return name in _KEYWORDS or keyword.iskeyword(name)


def free_name(name: str, taken: Container[str] = ()) -> str:
    """Return a name of a field; `_value` follows a keyword, and a name of `taken`."""
    return f"{name}_value" if is_reserved(name) or name in taken else name


class Form(NamedTuple):
    """The type of a field: its text, and what its default is read as.

    `kind` is None for strings, of at most `bound`; `has_default`: a default is possible.
    """

    text: str
    kind: Primitive | None = None
    bound: int | None = None
    has_default: bool = True


def form_of(
    model: Model, type_: Type, written: Callable[[ScopedName], bool], *, exact: bool
) -> Form:
    """Return the type of a field; `written` returns whether a struct has a message.

    `exact`: the hash of the message is known, so a similar type does not do. Raises
    InexpressibleError.
    """
    type_ = model.unalias(type_)
    suffix = ""
    if isinstance(type_, SequenceType):
        suffix = f"[{'' if type_.bound is None else f'<={type_.bound}'}]"
        type_ = model.unalias(type_.element)
    elif isinstance(type_, ArrayType):
        if len(type_.dimensions) > 1:
            raise InexpressibleError("arrays of several dimensions")
        suffix = f"[{type_.dimensions[0]}]"
        type_ = model.unalias(type_.element)
    element = _element(model, type_, written, exact)
    return element._replace(text=f"{element.text}{suffix}")


def _element(
    model: Model, type_: Type, written: Callable[[ScopedName], bool], exact: bool
) -> Form:
    match type_:
        case SequenceType() | ArrayType():
            raise InexpressibleError("sequences and arrays in each other")
        case StringType(wide=wide, bound=bound):
            name = "wstring" if wide else "string"
            return Form(name if bound is None else f"{name}<={bound}", None, bound)
        case PrimitiveType(kind=kind) if kind in _NAMES:
            if not (exact and kind in _INEXACT):
                read = Primitive.UINT8 if kind == Primitive.CHAR else kind
                return Form(_NAMES[kind], Primitive(read))
        case NamedType(name=name):
            declaration = model.find(name)
            if isinstance(declaration, Enum) and declaration.bound == 32 and not exact:
                return Form("uint32", Primitive.UNSIGNED_LONG)
            if isinstance(declaration, Struct) and written(name):
                return Form(reference(name), has_default=False)
    raise InexpressibleError(f"the type {type_}")
