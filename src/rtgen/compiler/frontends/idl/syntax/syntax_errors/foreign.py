"""Recognizes words and types of other languages."""

from __future__ import annotations

from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.syntax.foreign_words import TYPES, WORDS
from rtgen.compiler.frontends.idl.syntax.keywords import RESERVED
from rtgen.compiler.frontends.idl.syntax.syntax_errors.context import ErrorContext, Word
from rtgen.compiler.frontends.kit.syntax_errors import Recovery

_UNSIGNED = {
    "char": "write octet for a byte without sign",
    "int": "write unsigned long (32 bits)",
    "double": "write double: floating-point numbers have a sign",
    "float": "write float: floating-point numbers have a sign",
    "octet": "write octet: it has no sign",
    "byte": "write octet: it has no sign",
}
_COMBINED = {
    ("long", "float"): "write double",
    ("long", "int"): "write long",
    ("short", "int"): "write short",
    ("long", "long", "int"): "write long long",
    ("long", "long", "long"): "write long long",
    ("long", "short"): "write long or short",
    ("short", "long"): "write long or short",
    ("short", "float"): "write float",
    ("double", "long"): "write long double or double",
}


def superfluous(s: ErrorContext) -> Recovery | None:
    """Recognize `in const string a`, `interface B : public A`, `enum class E`."""
    if s.text == "const" and (s.in_parameters or s.previous == "<"):
        hint = "leave the word out: IDL passes values"
        return _other_language(s, Word(s.text, s.start, s.end), hint, drop=True)
    if s.text in ("public", "private") and s.previous in (":", ","):
        hint = "leave the word out: bases are public"
        return _other_language(s, Word(s.text, s.start, s.end), hint, drop=True)
    if s.first == "enum" and s.previous in ("class", "struct"):
        hint = "leave the word out"
        return _other_language(s, (s.before[0].start, s.before[-1].end), hint)
    return None


def inclusion(s: ErrorContext) -> Recovery | None:
    """Recognize `import file.idl;`, `include "file.idl"`."""
    if s.text == "import" and s.kind == "IDENT" and "IDENT" not in s.accepted:
        s.unit.lacking = True
        hint = (
            'write #include "file.idl" for a file; import takes a name and a semicolon'
        )
        return s.recover(
            syntax.UNEXPECTED, "'import' does not accept a file name", hint
        )
    if s.text == "include":
        s.unit.lacking = True
    return None


def word(s: ErrorContext) -> Recovery | None:
    """Recognize a word of another language: the token, or the one before it."""
    hint = WORDS.get(s.text)
    if hint is not None and s.kind == "IDENT" and "IDENT" not in s.accepted:
        return _other_language(s, Word(s.text, s.start, s.end), hint)
    last = s.before[-1] if s.before else None
    reserved = s.text in RESERVED
    if s.text == "<" and last is not None and last.is_name:
        scoped = "".join(w.text for w in s.before[-3:])
        at = s.before[-3] if "::" in scoped and scoped in TYPES else last
        hint = TYPES.get(scoped) or TYPES.get(last.text)
        if hint is not None:
            return _other_language(s, (at.start, last.end), hint)
    named = _named_before(s, reserved)
    if named is not None:
        return named
    if [w.text for w in s.before[-2:]] == ["std", "::"]:
        hint = TYPES.get(f"std::{s.text}")
        if hint:
            return _other_language(s, (s.before[-2].start, s.end), hint)
    return None


def _named_before(s: ErrorContext, reserved: bool) -> Recovery | None:
    """Recognize another language by the first or the last word before the token."""
    if not s.before:
        return None
    first, last = s.before[0], s.before[-1]
    for word in (first, last):
        hint = WORDS.get(word.text) or TYPES.get(word.text)
        if hint is None or not word.is_name:
            continue
        if word is first and len(s.before) > 2 and word.text not in WORDS:
            continue
        if reserved or s.text in "<{(" or (word is first and s.kind == "IDENT"):
            return _other_language(s, word, hint)
    return None


def _other_language(
    s: ErrorContext, at: Word | tuple[int, int], hint: str, *, drop: bool = False
) -> Recovery:
    start, end = (at.start, at.end) if isinstance(at, Word) else at
    word = s.unit.text[start:end]
    return s.recover(
        syntax.FOREIGN,
        f"IDL has no '{word}' here" if drop else f"IDL has no '{word}'",
        hint,
        at=(start, end),
        instead=drop,
    )


def number_type(s: ErrorContext) -> Recovery | None:
    """Recognize `unsigned double`, `long int`, `long float`."""
    if s.previous == "unsigned" and s.accepted <= {"LONG", "SHORT"}:
        word = s.before[-1]
        hint = _UNSIGNED.get(
            s.text, "write unsigned short, unsigned long or unsigned long long"
        )
        is_unsigned = s.text in _UNSIGNED
        until = s.end if is_unsigned else word.end
        text = f"unsigned {s.text}" if is_unsigned else "unsigned"
        return s.recover(
            syntax.FOREIGN,
            f"'{text}' is not a type",
            hint,
            at=(word.start, until),
            feed=("LONG",),
            resume=until if is_unsigned else s.start,
        )
    texts = [w.text for w in s.before]
    for run, hint in _COMBINED.items():
        size = len(run)
        if run[-1] == s.text and tuple(texts[len(texts) - size + 1 :]) == run[:-1]:
            start = s.before[len(texts) - size + 1].start
            return s.recover(
                syntax.FOREIGN,
                f"'{' '.join(run)}' is not a type",
                hint,
                at=(start, s.end),
                instead=True,
            )
        if s.kind == "IDENT" and tuple(texts[-size:]) == run and run[-1] == "int":
            return s.recover(
                syntax.FOREIGN,
                f"'{' '.join(run)}' is not a type",
                hint,
                at=(s.before[-size].start, s.before[-1].end),
            )
    return None
