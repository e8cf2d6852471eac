"""Generators of declarations of every kind for the grammar-based fuzzer."""

from __future__ import annotations

from dataclasses import replace

import idl_words as words
from idl_programs import Known, Program, Shape


def end(p: Program) -> None:
    """End a declaration."""
    if not p.slip():
        p.put(";")


def const(p: Program) -> None:
    """Declare a constant of any type that can have constants."""
    tokens, shape = p.basic()
    named = [t for t in p.types if t.shape.sort in _CONSTANT]
    if named and p.odds(0.3):
        known = p.chance.choice(named)
        tokens, shape = p.to(known), known.shape
    if shape.sort not in _CONSTANT and not p.slip():
        tokens, shape = p.integer(p.chance.choice(["long", "short", "octet"]))
    value, number = p.constant(shape)
    name = p.name()
    p.put("const", *tokens, name, "=", *value)
    end(p)
    p.constants.append(Known(p.path(name), shape, number))


_CONSTANT = (
    "integer",
    "float",
    "boolean",
    "char",
    "wchar",
    "string",
    "wstring",
    "enum",
    "fixed",
)


def typedef(p: Program) -> None:
    """Declare a typedef of one to three declarators."""
    tokens, shape = in_place(p) if p.odds(0.15) else p.type()
    p.put("typedef", *tokens)
    for index in range(p.chance.choice((1, 1, 1, 2, 3))):
        if index:
            p.put(",")
        name = p.name()
        p.put(name)
        p.types.append(Known(p.path(name), dimensions(p, shape)))
    end(p)


def dimensions(p: Program, shape: Shape) -> Shape:
    """Add the dimensions of an array, or none."""
    if not p.odds(0.15):
        return shape
    for _ in range(p.chance.randint(1, 3)):
        p.put("[", *p.bound(p.chance.randint(1, 6)), "]")
    return Shape("array", local=shape.local)


def in_place(p: Program) -> tuple[list[str], Shape]:
    """Return a type that is declared at its use."""
    start = len(p.tokens)
    p.chance.choice((struct, union, enum))(p, ended=False)
    tokens = p.tokens[start:]
    del p.tokens[start:]
    return tokens, p.types[-1].shape


def members(p: Program, *, owner: Shape) -> Shape:
    """Declare the members of a struct or exception."""
    local = owner.local
    least = 0 if not p.style.corba and p.odds(0.05) else 1
    for _ in range(p.chance.randint(least, 5)):
        if not p.style.corba and p.odds(0.2):
            annotate(p)
        tokens, shape = in_place(p) if p.odds(0.04) and len(p.scope) < 6 else p.type()
        local = local or shape.local
        p.put(*tokens)
        for index in range(p.chance.choice((1, 1, 1, 1, 2))):
            if index:
                p.put(",")
            p.put(p.name("m"))
            dimensions(p, shape)
        end(p)
    return replace(owner, local=local)


def annotate(p: Program) -> None:
    """Add an annotation of a member."""
    if p.slip():
        p.put(p.chance.choice(words.ANNOTATIONS))
        return
    p.count += 1
    p.put(
        p.chance.choice(
            (
                "@key",
                "@optional",
                '@unit("m")',
                "@must_understand",
                "@external",
                "@unheard_of(a=1)",
                '@verbatim(language="c", text="/* x */")',
                "@a::b",
                "@hashid",
            )
        )
    )


def struct(p: Program, *, ended: bool = True) -> None:
    """Declare a struct; in IDL 4 sometimes with a base."""
    if not p.style.corba and p.odds(0.1):
        p.put(
            p.chance.choice(
                ("@final", "@appendable", "@mutable", "@extensibility(FINAL)")
            )
        )
    forward = ended and p.odds(0.1)
    name = p.name()
    local = False
    if forward:
        p.put("struct", name, ";")
        items = p.name()
        p.put("typedef", "sequence", "<", name, ">", items, ";")
    p.put("struct", name)
    bases = [t for t in p.types if t.shape.sort == "struct" and t.shape.simple]
    if bases and not forward and not p.style.corba and p.odds(0.15):
        base = p.chance.choice(bases)
        local = base.shape.local
        p.put(":", *p.to(base))
    p.put("{")
    outer, p.scope = p.scope, p.path(name)
    if forward:
        p.put(items, p.name("m"), ";")
    shape = members(p, owner=Shape("struct", local=local))
    p.scope = outer
    if not p.slip():
        p.put("}")
    if ended:
        end(p)
    p.types.append(Known(p.path(name), shape))


def union(p: Program, *, ended: bool = True) -> None:
    """Declare a union on any discriminator, with distinct labels."""
    name = p.name()
    switches = [t for t in p.types if t.shape.sort in _SWITCH]
    if switches and p.odds(0.4):
        known = p.chance.choice(switches)
        tokens, shape = p.to(known), known.shape
    elif p.odds(0.2):
        tokens, shape = p.chance.choice((["boolean"], ["char"])), Shape("boolean")
        shape = Shape(tokens[0])
    else:
        tokens, shape = p.integer(
            p.chance.choice(["long", "short", "unsigned long", "long long"])
        )
    if p.slip():
        tokens, shape = p.type()
    p.put("union", name, "switch", "(", *tokens, ")", "{")
    outer, p.scope = p.scope, p.path(name)
    local = False
    labels = distinct(p, shape)
    while labels:
        for _ in range(p.chance.choice((1, 1, 2))):
            if labels:
                p.put("case", *labels.pop(), ":")
                if p.slip():
                    p.put("case", "1", ":")
        tokens, branch = p.type()
        local = local or branch.local
        p.put(*tokens, p.name("m"))
        dimensions(p, branch)
        end(p)
    if (shape.sort == "integer" and p.odds(0.4)) or p.slip():
        p.put("default", ":", *p.basic()[0], p.name("m"))
        end(p)
    p.scope = outer
    p.put("}")
    if ended:
        end(p)
    p.types.append(Known(p.path(name), Shape("union", local=local)))


_SWITCH = ("integer", "boolean", "char", "enum")


def distinct(p: Program, shape: Shape) -> list[list[str]]:
    """Return labels of a discriminator with distinct values."""
    count = p.chance.randint(1, 5)
    match shape.sort:
        case "boolean":
            return [["TRUE"], ["FALSE"]][: p.chance.randint(1, 2)]
        case "enum":
            some = p.chance.sample(shape.values, min(count, len(shape.values)))
            return [p.to(Known(path, shape)) for path in some]
        case "char":
            return [[f"'{c}'"] for c in p.chance.sample("abcxyz09", count)]
        case "integer":
            high = min(shape.high, 100)
            low = max(shape.low, -100)
            found = p.chance.sample(range(low, high), count)
            return [["-", str(-v)] if v < 0 else [str(v)] for v in found]
    return [["0"]]


def enum(p: Program, *, ended: bool = True) -> None:
    """Declare an enum."""
    name = p.name()
    names = [p.name("K") for _ in range(p.chance.randint(1, 6))]
    p.put("enum", name, "{")
    value = 0
    for index, each in enumerate(names):
        if index:
            p.put(",")
        if not p.style.corba and p.odds(0.05) and index == 0:
            value = p.chance.randint(0, 9)
            p.put("@value", "(", str(value), ")")
        p.put(each)
    if p.slip():
        p.put(",")
    p.put("}")
    if ended:
        end(p)
    values = tuple(p.path(each) for each in names)
    p.types.append(Known(p.path(name), Shape("enum", values=values)))


def exception(p: Program) -> None:
    """Declare an exception."""
    name = p.name()
    p.put("exception", name, "{")
    if p.odds(0.8):
        outer, p.scope = p.scope, p.path(name)
        members(p, owner=Shape("exception"))
        p.scope = outer
    p.put("}")
    end(p)
    p.exceptions.append(Known(p.path(name), Shape("exception")))


def native(p: Program) -> None:
    """Declare a native type."""
    name = p.name()
    p.put("native", name)
    end(p)
    p.types.append(Known(p.path(name), Shape("native")))


def bitset(p: Program) -> None:
    """Declare a bitset of at most 64 bits."""
    name = p.name()
    p.put("bitset", name, "{")
    left = 64
    for _ in range(p.chance.randint(1, 5)):
        bits = p.chance.randint(1, 20)
        if bits > left and not p.slip():
            break
        left -= bits
        kind = [",", "long"] if p.odds(0.2) else []
        p.put("bitfield", "<", *p.bound(bits), *kind, ">")
        if p.odds(0.9):
            p.put(p.name("f"))
        end(p)
    p.put("}")
    end(p)
    p.types.append(Known(p.path(name), Shape("bitset")))


def bitmask(p: Program) -> None:
    """Declare a bitmask."""
    name = p.name()
    if p.odds(0.2):
        p.put("@bit_bound", "(", p.chance.choice(("8", "16", "64")), ")")
    p.put("bitmask", name, "{")
    for index in range(p.chance.randint(1, 5)):
        if index:
            p.put(",")
        if p.odds(0.2):
            p.put("@position", "(", str(7 if p.slip() else index), ")")
        p.put(p.name("F"))
    p.put("}")
    end(p)
    p.types.append(Known(p.path(name), Shape("bitmask")))


def annotation(p: Program) -> None:
    """Declare an annotation, and use it."""
    p.count += 1
    name = f"note{p.count}"
    p.put("@annotation", name, "{", "long", "level", "default", "3", ";")
    p.put("string", "text", "default", '"x"', ";", "}", ";")
    p.put(f"@{name}", "(", "level", "=", "2", ")")
    struct(p)


def inclusion(p: Program) -> None:
    """Include a file, and use its types."""
    if not p.included and not p.slip():
        return typedef(p)
    name = p.name()
    types = ("Inc::Item", "Inc::Items", "::Inc::Tone", "Inc::Thing")
    p.put("typedef", *p.chance.choice(types).replace("::", " :: ").split(), name)
    end(p)
    p.types.append(Known(p.path(name), Shape("included")))
    return None


def boxed(p: Program) -> None:
    """Declare a value box."""
    tokens, shape = p.type()
    if shape.sort == "value" and not p.slip():
        tokens, shape = p.basic()
    name = p.name()
    p.put("valuetype", name, *tokens)
    end(p)
    p.types.append(Known(p.path(name), Shape("value", local=shape.local)))
