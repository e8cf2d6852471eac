"""Text of functions of signatures in CDL."""

from __future__ import annotations

from rtgen.compiler.model.tecs import Sizes, TecsFunction


def function_text(function: TecsFunction, name: str | None = None) -> str:
    """Return the function as CDL declares it, with `name` in place of its own."""
    parameters = ", ".join(
        f"[{', '.join([str(p.direction), *sizes_text(p.sizes)])}] {_declared(p.type, p.name)}"
        for p in function.parameters
    )
    oneway = "[oneway] " if function.oneway else ""
    named = function.name if name is None else name
    return f"{oneway}{function.returns} {named}({parameters or 'void'})"


def sizes_text(sizes: Sizes) -> list[str]:
    """Return the specifiers of a parameter other than its direction."""
    texts = []
    if sizes.size_is is not None:
        most = "" if sizes.max_size is None else f", {sizes.max_size}"
        texts.append(f"size_is({sizes.size_is}{most})")
    if sizes.count_is is not None:
        texts.append(f"count_is({sizes.count_is})")
    if sizes.string is not None:
        texts.append(f"string({sizes.string})")
    elif sizes.is_string:
        texts.append("string")
    if sizes.nullable:
        texts.append("nullable")
    return texts


def _declared(type_: object, name: str) -> str:
    text = str(type_)
    if text.endswith("]") and "[" in text:
        head, bracket, tail = text.partition("[")
        return f"{head} {name}{bracket}{tail}"
    return f"{text[:-1]} *{name}" if text.endswith("*") else f"{text} {name}"
