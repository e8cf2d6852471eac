"""Recognizes files in other languages called IDL, by constructs that OMG IDL does not have."""

from __future__ import annotations

import re

_TEXT = re.compile(r'"(?:\\.|[^"\\\n])*"')
_LIST = r"(?:\A|[(,;{}]|\btypedef\b)\s*\[\s*(?:[\w(=][\w(=) ]*,\s*)*"
"""The start of an attribute list: OMG IDL has no bracket after these characters."""

_LANGUAGES: dict[str, tuple[str, ...]] = {
    "XPIDL, the language of Mozilla's interfaces": (
        r"^%\{",
        rf"{_LIST}(?:scriptable|builtinclass|rust_sync)\b",
    ),
    "UNO's IDL, the language of LibreOffice's interfaces": (
        r"\bpublished\s+(?:interface|service|singleton|struct|exception|enum|typedef|constants)\b",
        r"\bmodule\s+com\s*\{\s*module\s+sun\s*\{\s*module\s+star\b",
        r"\bsingleton\s+\w+\s*[:{]",
        r"\bservice\s+\w+\s*:",
        r"\bconstants\s+\w+\s*\{",
        r"[;{]\s*\[\s*(?:attribute|property)\b",
    ),
    "Web IDL, the language of web browsers' interfaces": (
        r"\bpartial\s+(?:interface|dictionary|namespace)\b",
        r"\binterface\s+mixin\b",
        r"\bcallback\s+(?:interface\b|\w+\s*=)",
        r"\bdictionary\s+\w+\s*(?::\s*\w+\s*)?\{",
        r"\b(?:Promise|FrozenArray|record|maplike|setlike|iterable)\s*<",
        r"\btypedef\s*\([\w\s<>,?]{1,200}?\bor\b",
        r"[;}]\s*\w+\s+(?:includes|implements)\s+\w+\s*;",
        rf"{_LIST}(?:Exposed|Global|Constructor|SecureContext|NoInterfaceObject|NewObject"
        r"|SameObject|CEReactions|Legacy\w+|PutForwards|Replaceable|Treat\w+)\b",
    ),
    "Microsoft's or DCE's IDL": (
        r"\bcpp_quote\s*\(",
        r"\bmidl_pragma\b",
        r"\bimportlib\s*\(",
        r"\b(?:coclass|dispinterface)\s+\w+\s*[;{]",
        rf"{_LIST}(?:uuid|object|dual|oleautomation|odl|pointer_default|helpstring|endpoint"
        r"|implicit_handle|auto_handle|size_is|length_is|switch_is|switch_type|case|retval"
        r"|in\s*,|out\s*,|in\s*\]\s*(?:const\s+)?[A-Z]{3,}\b|unique|ref|ptr|v1_enum)\b",
        r"\blibrary\s+\w+\s*\{",
        rf"{_LIST}(?:in|out)\s*\](?=.*{_LIST}(?:in|out)\s*\])",
    ),
}
_EVIDENCE = {
    language: re.compile("|".join(patterns), re.MULTILINE | re.DOTALL)
    for language, patterns in _LANGUAGES.items()
}


def other_language(text: str) -> tuple[str, int, int] | None:
    """Return the language of a text, and the place that reveals it; None for OMG IDL.

    Only called for a text with a syntax error, whose comments are blanked.
    """
    blank = _TEXT.sub(lambda match: '""' + " " * (len(match[0]) - 2), text)
    for language, evidence in _EVIDENCE.items():
        hit = evidence.search(blank)
        if hit is not None:
            said = hit[0].rstrip()
            line = said.rpartition("\n")[2].lstrip(",;{}( \t")
            end = hit.start() + len(said)
            return language, end - len(line), end
    return None
