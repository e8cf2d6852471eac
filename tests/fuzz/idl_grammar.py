"""The grammar-based fuzzer: valid programs, programs with errors, and texts of the bare grammar."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import idl_declarations as declarations
import idl_interfaces as interfaces
import idl_words as words
from fuzzing import log_uniform
from idl_declarations import end
from idl_programs import Known, Program, Shape, Style
from idl_sampler import sample
from idl_writing import write


def program(number: int) -> bytes:
    """Return the input of a case."""
    chance = Random(number)
    style = _style(number, chance)
    if style is None:
        return write(chance, sample(chance), faithful=False)
    grown = Program(chance, style)
    declare(grown)
    return write(chance, grown.tokens, faithful=_is_faithful(style))


def is_valid(number: int) -> bool:
    """Return whether the input of a case is a valid program."""
    style = _style(number, Random(number))
    return style is not None and _is_faithful(style)


def _style(number: int, chance: Random) -> Style | None:
    """Return the style of a case's program; None for a text of the bare grammar."""
    if number % 5 == 4:
        return None
    return Style(
        flaws=chance.choice((0.0, 0.0, 0.004, 0.02, 0.08)),
        unique=chance.random() < 0.75,
        most=log_uniform(1, 9 if chance.random() < 0.995 else 200, chance.random()),
        corba=chance.random() < 0.2,
    )


def _is_faithful(style: Style) -> bool:
    return style.flaws == 0 and style.unique


def declare(p: Program) -> None:
    """Generate a program."""
    if p.odds(0.04):
        p.line(p.chance.choice(('#include "guarded.idl"', "#include <guarded.idl>")))
        p.line("#include <once.idl>")
        p.included = True
    while p.made < p.style.most:
        definition(p, 0)


def definition(p: Program, depth: int) -> None:
    """Generate one definition of a module or the file."""
    p.made += 1
    if p.slip():
        return noise(p)
    if p.odds(0.05):
        conditional(p, depth)
        return None
    kinds = _KINDS if p.style.corba else _LATER
    if depth < 4 and p.odds(0.12):
        module(p, depth)
    else:
        p.chance.choices([k for k, _ in kinds], [w for _, w in kinds])[0](p)
    if p.odds(0.06):
        pragma(p)
    return None


def noise(p: Program) -> None:
    """Generate an invalid declaration."""
    pools = (
        words.KEYWORDS,
        words.NEAR,
        words.MARKS,
        words.NUMBERS,
        words.TEXTS,
        words.NAMES,
    )
    if p.odds(0.2):
        p.line(p.chance.choice(words.LINES))
    p.put(
        *(
            p.chance.choice(p.chance.choice(pools))
            for _ in range(p.chance.randint(1, 4))
        )
    )


def conditional(p: Program, depth: int) -> None:
    """Generate a definition under a true condition, beside text that is left out."""
    condition = p.chance.choice(
        (
            "#if 1",
            "#ifndef ABSENT",
            "#if !defined(ABSENT) && 2 > 1",
            "#if (1 << 3) == 8 || ABSENT",
            "#ifdef __OMNIIDL__",
            "#if 'a' == 97 ? 1 : 0",
        )
    )
    p.line(condition)
    definition(p, depth)
    if p.odds(0.5):
        p.line("#else")
        p.put("struct", "absent", "{", "5", "}")
    if not p.slip():
        p.line("#endif")


def pragma(p: Program) -> None:
    """Generate a pragma for something declared, or for what follows."""
    known = [k for k in (*p.types, *p.interfaces) if k.path[:-1] == p.scope]
    kind = p.chance.randrange(5)
    if kind == 0:
        p.line(f'#pragma prefix "{p.chance.choice(("", "a.org", "b/c"))}"')
    elif kind == 1:
        p.line(
            p.chance.choice(
                ("#pragma keylist T a b", "#pragma hdrstop", "#pragma once")
            )
        )
    elif known and not p.style.corba:
        p.count += 1
        name = p.chance.choice(known)
        if name.path in p.identified:
            return
        p.identified.add(name.path)
        if kind == 2:
            p.line(f'#pragma ID {name.path[-1]} "IDL:own/Id{p.count}:1.0"')
        else:
            p.put("typeid", *p.to(name), f'"IDL:own/Id{p.count}:1.0"', ";")


def module(p: Program, depth: int) -> None:
    """Generate a module, perhaps one that is open already."""
    here = [m for m in p.modules if m.path[:-1] == p.scope]
    if here and p.odds(0.3):
        name = p.chance.choice(here).path[-1]
    else:
        name = p.name()
        p.modules.append(Known(p.path(name), Shape("module")))
    p.put("module", name, "{")
    outer, p.scope = p.scope, p.path(name)
    for _ in range(p.chance.randint(1, 4)):
        definition(p, depth + 1)
    p.scope = outer
    if not p.slip():
        p.put("}")
    end(p)


_KINDS: list[tuple[Callable[[Program], None], int]] = [
    (declarations.const, 8),
    (declarations.typedef, 8),
    (declarations.struct, 10),
    (declarations.union, 6),
    (declarations.enum, 5),
    (declarations.exception, 4),
    (declarations.native, 1),
    (declarations.boxed, 1),
    (declarations.inclusion, 1),
    (interfaces.interface, 9),
    (interfaces.forward, 1),
    (interfaces.value, 5),
]
_LATER: list[tuple[Callable[[Program], None], int]] = [
    *_KINDS,
    (declarations.bitset, 2),
    (declarations.bitmask, 2),
    (declarations.annotation, 1),
    (interfaces.component, 3),
    (interfaces.reading_only, 1),
]
