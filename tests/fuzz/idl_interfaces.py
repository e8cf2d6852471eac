"""Generators of interfaces, valuetypes and components for the grammar-based fuzzer."""

from __future__ import annotations

import idl_words as words
from idl_declarations import (
    const,
    end,
    enum,
    exception,
    struct,
    typedef,
    union,
)
from idl_programs import Known, Program, Shape

_EXPORTS = (const, typedef, struct, union, enum, exception)


def interface(p: Program) -> None:
    """Declare an interface of any kind, with bases."""
    sort = p.chance.choice(("", "", "", "abstract", "local"))
    name = p.name()
    if p.odds(0.1):
        p.put(*sort.split(), "interface", name, ";")
    p.put(*sort.split(), "interface", name)
    fitting = [
        k for k in p.interfaces if sort == "local" or k.shape.sort in ("abstract", sort)
    ]
    if p.slip():
        fitting = [*p.interfaces, *p.types]
    if fitting and p.odds(0.5):
        bases = p.chance.sample(
            fitting, min(len(fitting), p.chance.choice((1, 1, 2, 3)))
        )
        inherit(p, ":", bases)
    p.put("{")
    outer, p.scope = p.scope, p.path(name)
    for _ in range(p.chance.randint(0, 5)):
        export(p, local=sort == "local")
    p.scope = outer
    p.put("}")
    end(p)
    known = Known(p.path(name), Shape(sort, local=sort == "local"))
    p.interfaces.append(known)
    p.types.append(Known(known.path, Shape("interface", local=sort == "local")))


def forward(p: Program) -> None:
    """Declare an interface that is used before it is defined, or never defined."""
    name = p.name()
    p.put("interface", name, ";")
    p.types.append(Known(p.path(name), Shape("interface")))


def inherit(p: Program, mark: str, bases: list[Known]) -> None:
    """Add a list of bases."""
    p.put(mark)
    for index, base in enumerate(bases):
        if index:
            p.put(",")
        p.put(*p.to(base))


def export(p: Program, *, local: bool) -> None:
    """Declare a member of an interface or valuetype."""
    kind = p.chance.random()
    if kind < 0.25:
        p.chance.choice(_EXPORTS)(p)
    elif kind < 0.5:
        attribute(p, local=local)
    else:
        operation(p, local=local)


def attribute(p: Program, *, local: bool) -> None:
    """Declare one or more attributes."""
    readonly = p.odds(0.3)
    p.put(*["readonly"] * readonly, "attribute", *p.simple(local=local)[0], p.name())
    raising = p.exceptions and not p.style.corba and p.odds(0.2)
    if raising:
        raises(p, "raises" if readonly else p.chance.choice(("getraises", "setraises")))
    elif p.odds(0.2):
        p.put(",", p.name())
    end(p)


def raises(p: Program, word: str) -> None:
    """Add a list of exceptions."""
    some = p.chance.sample(
        p.exceptions, min(len(p.exceptions), p.chance.choice((1, 1, 2)))
    )
    p.put(word, "(")
    for index, known in enumerate(some):
        if index:
            p.put(",")
        p.put(*(p.simple()[0] if p.slip() else p.to(known)))
    p.put(")")


def parameters(p: Program, *, only: str = "", local: bool = False) -> None:
    """Add a list of parameters."""
    p.put("(")
    for index in range(p.chance.choice((0, 1, 1, 2, 3))):
        if index:
            p.put(",")
        direction = only or p.chance.choice(("in", "in", "out", "inout"))
        if not p.slip():
            p.put(direction)
        p.put(*p.simple(local=local)[0], p.name("p"))
    p.put(")")


def operation(p: Program, *, local: bool) -> None:
    """Declare an operation of any form."""
    oneway = p.odds(0.1)
    result = ["void"] if oneway or p.odds(0.4) else p.simple(local=local)[0]
    p.put(*["oneway"] * oneway, *result, p.name())
    parameters(p, only="" if not oneway or p.slip() else "in", local=local)
    if p.exceptions and p.odds(0.3) and (not oneway or p.slip()):
        raises(p, "raises")
    if p.odds(0.05):
        p.put("context", "(", p.chance.choice(('"a"', '"a.b_c*"', '"a", "b"')), ")")
    end(p)


def value(p: Program) -> None:
    """Declare a valuetype or eventtype with state, factories and bases."""
    sort = p.chance.choice(("", "", "", "abstract", "custom"))
    word = "eventtype" if not p.style.corba and p.odds(0.1) else "valuetype"
    name = p.name()
    if p.odds(0.08):
        p.put(*["abstract"] * (sort == "abstract"), word, name, ";")
    p.put(*sort.split(), word, name)
    concrete = [k for k in p.values if k.shape.sort == "" and k.value == word]
    abstract = [k for k in p.values if k.shape.sort == "abstract" and k.value == word]
    bases: list[Known] = []
    if sort != "abstract" and concrete and p.odds(0.3):
        bases.append(p.chance.choice(concrete))
        mark = ":"
        truncatable = sort != "custom" and p.odds(0.3)
    else:
        mark, truncatable = ":", False
    if abstract and p.odds(0.3):
        bases.append(p.chance.choice(abstract))
    if p.slip():
        bases = [*bases, *p.types[:1], *p.interfaces[:1]]
    if bases:
        p.put(mark, *["truncatable"] * truncatable)
        tail = len(p.tokens)
        inherit(p, ",", bases)
        del p.tokens[tail]
    supported = [k for k in p.interfaces if k.shape.sort == ""]
    if supported and p.odds(0.2) and not bases:
        inherit(p, "supports", [p.chance.choice(supported)])
    p.put("{")
    outer, p.scope = p.scope, p.path(name)
    for _ in range(p.chance.randint(0, 4)):
        kind = p.chance.random()
        if (kind < 0.5 and sort != "abstract") or p.slip():
            p.put(p.chance.choice(("public", "private")), *p.type()[0], p.name("s"))
            end(p)
        elif kind < 0.65 and sort != "abstract":
            p.put("factory", p.name())
            parameters(p, only="in")
            end(p)
        else:
            export(p, local=False)
    p.scope = outer
    p.put("}")
    end(p)
    p.values.append(Known(p.path(name), Shape(sort), word))
    p.types.append(Known(p.path(name), Shape("value")))


def component(p: Program) -> None:
    """Declare a component with ports and configuration."""
    if p.odds(0.5):
        p.put("@rtc", "(", "category", "=", '"Test"', ",", "rate", "=", "100.0", ")")
    name = p.name()
    p.put("component", name)
    if p.components and p.odds(0.2):
        inherit(p, ":", [p.chance.choice(p.components)])
    p.put("{")
    outer, p.scope = p.scope, p.path(name)
    data = [k for k in p.types if k.shape.sort in ("struct", "union")]
    for _ in range(p.chance.randint(0, 5)):
        if p.slip():
            p.put(p.chance.choice(words.CONTEXTUAL), *p.type()[0], p.name())
        elif data and p.odds(0.4):
            word = p.chance.choice(("publishes", "consumes", "emits"))
            p.put(word, *p.to(p.chance.choice(data)), p.name())
        elif p.interfaces and p.odds(0.5):
            if p.odds(0.2):
                p.put("@port", "(", '"Group"', ")")
            word = p.chance.choice(("provides", "uses"))
            p.put(word, *p.to(p.chance.choice(p.interfaces)), p.name())
        else:
            tokens, shape = p.integer(p.chance.choice(["long", "short"]))
            if p.odds(0.5):
                p.put("@default", "(", *p.constant(shape)[0], ")")
            p.put("attribute", *tokens, p.name())
        end(p)
    p.scope = outer
    p.put("}")
    end(p)
    p.components.append(Known(p.path(name), Shape("component")))


def reading_only(p: Program) -> None:
    """Declare something that is parsed, but left out with a warning."""
    name = p.name()
    match p.chance.randrange(5):
        case 0 if p.components:
            p.put("home", name, "manages", *p.to(p.chance.choice(p.components)), "{")
            p.put("factory", p.name(), "(", ")", ";", "}")
        case 1:
            p.put("porttype", name, "{", "attribute", "long", p.name(), ";", "}")
        case 2:
            p.put("connector", name, "{", "attribute", "long", p.name(), ";", "}")
        case 3 if p.modules:
            p.put("import", *p.to(p.chance.choice(p.modules)))
        case _:
            p.put("module", name, "<", "typename", "X", ">", "{")
            p.put("typedef", "sequence", "<", "X", ">", p.name(), ";", "}")
    end(p)
