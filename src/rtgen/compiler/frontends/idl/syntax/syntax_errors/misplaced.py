"""Recognizes misplaced constructs, and suggests their right place."""

from __future__ import annotations

from rtgen.compiler.frontends.idl.rules import syntax, types
from rtgen.compiler.frontends.idl.syntax.keywords import RESERVED
from rtgen.compiler.frontends.idl.syntax.syntax_errors.context import (
    ErrorContext,
    header,
)
from rtgen.compiler.frontends.kit.syntax_errors import Recovery

_DIRECTIONS = ("in", "out", "inout")
_CONTENTS = {
    "": "declarations such as modules, types and interfaces are allowed here",
    "module": "declarations such as modules, types and interfaces are allowed here",
    "struct": "each member is 'TYPE NAME;'",
    "exception": "each member is 'TYPE NAME;'",
    "union": "each branch is 'case VALUE: TYPE NAME;' or 'default: TYPE NAME;'",
    "enum": "names are allowed here, separated by ','",
    "bitmask": "names are allowed here, separated by ','",
    "bitset": "each field is 'bitfield<BITS> NAME;'",
    "interface": "operations, attributes, types, constants and exceptions are allowed here",
    "valuetype": "state, operations, attributes, factories, types and constants are allowed here",
    "component": "ports such as 'consumes TYPE NAME;' and attributes are allowed here",
}
_BASIC = frozenset(
    (
        *("short", "long", "unsigned", "float", "double", "char", "wchar", "boolean"),
        *("octet", "any", "string", "wstring", "sequence", "fixed", "void", "Object"),
    )
)
_OUTSIDE = {
    "const": "a constant is not allowed in a {body}",
    "typedef": "a typedef is not allowed in a {body}",
    "exception": "an exception is not allowed in a {body}",
    "interface": "an interface is not allowed in a {body}",
    "module": "a module is not allowed in a {body}",
    "valuetype": "a valuetype is not allowed in a {body}",
    "native": "a native type is not allowed in a {body}",
}
_ACCESS = ("public", "private", "protected")
_BODIES_OF_DATA = ("struct", "exception", "union")


def what_stands_here(s: ErrorContext) -> str:
    """Return a hint with the content that is allowed in the body around the token."""
    return _CONTENTS.get(s.construct, _CONTENTS[""])


def colon_after_access(s: ErrorContext) -> Recovery | None:
    """Recognize `public:` of C++."""
    if s.text in _ACCESS and s.following == ":":
        end = s.after[0].end
        return s.recover(
            syntax.FOREIGN,
            f"IDL has no '{s.text}:'",
            "remove it: members of structs and interfaces are public",
            at=(s.start, end),
            back=True,
            resume=end,
        )
    if s.text == ":" and s.first in _ACCESS and len(s.before) == 1:
        return s.recover(
            syntax.FOREIGN,
            f"IDL has no '{s.first}:'",
            "leave it out, or write it before each state member",
            at=(s.before[0].start, s.end),
            back=True,
            resume=s.end,
        )
    return None


def values(s: ErrorContext) -> Recovery | None:
    """Recognize casts and lists among the values of constants."""
    if "NUMBER" not in s.accepted or s.first != "const":
        return None
    if s.text in _BASIC and s.previous == "(":
        hint = "write a value of the type of the constant"
        return _foreign(s, "IDL has no casts", hint)
    if s.text == "{":
        hint = "constants are numbers, characters, strings, booleans and enumerators"
        return _foreign(s, "a constant holds a single value in IDL", hint)
    return None


def misplaced_direction(s: ErrorContext) -> Recovery | None:
    """Recognize `long in a`, `in out long a`."""
    if s.text not in _DIRECTIONS or not s.in_parameters:
        return None
    if s.previous in _DIRECTIONS:
        return s.recover(
            syntax.UNEXPECTED,
            f"'{s.previous}' and '{s.text}' cannot be combined",
            "a parameter has one direction: in, out or inout",
        )
    if s.following not in (",", ")", "["):
        return s.recover(
            syntax.UNEXPECTED,
            f"'{s.text}' belongs before the type of the parameter",
            f"write '{s.text} TYPE NAME'",
        )
    return None


def misplaced_clause(s: ErrorContext) -> Recovery | None:
    """Recognize `void raises (E) f()`, `raises E`."""
    if s.text == "Object" and s.first == "interface" and s.previous in (":", ","):
        return s.recover(
            types.BAD_BASE,
            "Object cannot be named as a base",
            "leave it out: every interface is an Object",
        )
    if s.text == "raises" and s.following == "(" and "RAISES" not in s.accepted:
        return s.recover(
            syntax.UNEXPECTED,
            "'raises' follows the parameters",
            "write TYPE NAME(...) raises (EXCEPTION)",
        )
    if s.previous in ("raises", "getraises", "setraises") and s.kind == "IDENT":
        return s.recover(
            syntax.MISSING_MARK,
            f"a '(' is missing after '{s.previous}'",
            f"write {s.previous} ({s.text})",
        )
    return None


def misplaced(s: ErrorContext) -> Recovery | None:
    """Recognize a declaration in a body that does not allow it."""
    if s.before:
        return _method(s)
    body = s.construct
    if body in _BODIES_OF_DATA:
        if s.text in _OUTSIDE:
            message = _OUTSIDE[s.text].format(body=body)
            return _move(s, message, f"put it before the {body}")
        if s.text in ("attribute", "readonly", "oneway"):
            message = f"'{s.text}' is not allowed in a {body}"
            return _move(
                s, message, "attributes and operations belong into an interface"
            )
        if s.text in _ACCESS:
            message = f"'{s.text}' is not allowed in a {body}"
            return _move(s, message, "leave it out, or make this a valuetype")
    if body in ("interface", "component"):
        if s.text in _ACCESS:
            message = f"'{s.text}' is not allowed in an {body}"
            return _move(s, message, "remove it: members of an interface are public")
        if s.text in ("module", "interface", "valuetype", "component"):
            message = f"'{s.text}' is not allowed in an {body}"
            return _move(s, message, f"put it before the {body}")
    if body in ("", "module") and (s.text in _BASIC or s.kind == "IDENT"):
        return _outside_all(s)
    if body == "union" and (s.text in _BASIC or s.kind in ("NUMBER", "IDENT")):
        label = s.kind != "NUMBER" and s.following != ":"
        message = (
            "a branch begins with 'case VALUE:'" if label else "'case' is missing here"
        )
        return s.recover(syntax.UNEXPECTED, message, "write 'case VALUE: TYPE NAME;'")
    return None


def _move(s: ErrorContext, message: str, hint: str) -> Recovery:
    return s.recover(syntax.MISPLACED, message, hint)


def _outside_all(s: ErrorContext) -> Recovery | None:
    """Recognize a member or an operation at file scope or in a module."""
    ahead = [word.text for word in s.after]
    until = ahead.index(";") if ";" in ahead else 0
    if "{" in ahead[:until]:
        return None
    where = f"in a {s.construct}" if s.construct else "at file scope"
    if "(" in ahead[:until]:
        message = f"an operation is not allowed {where}"
        return _move(s, message, "put it into an interface")
    if s.text in _BASIC and until:
        message = f"a member is not allowed {where}"
        hint = "put it into a struct; or write typedef for a type, const for a constant"
        return _move(s, message, hint)
    return None


def _method(s: ErrorContext) -> Recovery | None:
    """Recognize an operation or an initial value among the members of a struct."""
    if s.text == "(" and s.construct in _BODIES_OF_DATA and "SEMI" in s.accepted:
        if s.following.isdigit():
            return s.recover(
                syntax.BAD_ARRAY,
                "the size of an array is written in brackets",
                f"write {s.previous}[{s.following}]",
            )
        message = f"an operation is not allowed in a {s.construct}"
        return _move(s, message, "put it into an interface")
    if s.text == "void" or s.construct != "interface":
        return None
    if s.text == "(" and len(s.before) == 1 and s.before[0].is_name:
        return s.recover(
            syntax.MISSING_WORD,
            f"the operation {s.previous} has no result type",
            "write void before the name if it returns nothing; IDL has no constructors",
            at=s.before[0],
        )
    return None


def assignment(s: ErrorContext) -> Recovery | None:
    """Recognize `=` where no value is allowed, and bodies of operations."""
    if (
        s.text == "{"
        and s.previous == ")"
        and s.construct in ("interface", "valuetype")
    ):
        return _foreign(
            s, "operations have no body in IDL", "end the declaration with ';'"
        )
    if s.text == "const" and s.previous == ")":
        message = "operations are not const in IDL"
        return s.recover(syntax.FOREIGN, message, "leave the word out", instead=True)
    if s.text != "=":
        return None
    if s.previous == "=":
        return s.recover(
            syntax.UNEXPECTED,
            "'==' is not allowed here",
            "write one '='",
            at=s.before[-1],
        )
    if s.in_parameters:
        return _foreign(
            s,
            "parameters have no default values in IDL",
            "leave the value out",
        )
    if s.first == "typedef":
        return _foreign(
            s, "'=' is not allowed in a typedef", "write typedef TYPE NAME;"
        )
    if s.construct in _BODIES_OF_DATA:
        return _foreign(
            s,
            "members have no initial values in IDL",
            "leave the value out, or write @default(VALUE) before the member",
        )
    if s.first == "const":
        return s.recover(
            syntax.MISSING_WORD,
            "the constant has no type, or no name",
            "write const TYPE NAME = VALUE;",
            at=s.before[-1],
        )
    if "attribute" in (word.text for word in s.before):
        return _foreign(
            s, "attributes have no initial values in IDL", "leave the value out"
        )
    if s.previous == ")":
        return _foreign(s, "operations are not defined in IDL", "leave the '= ...' out")
    return None


def _foreign(s: ErrorContext, message: str, hint: str) -> Recovery:
    return s.recover(syntax.FOREIGN, message, hint)


def brackets(s: ErrorContext) -> Recovery | None:
    """Recognize `long[3] a`, `a[]`, `a[2,3]`."""
    if s.text == "[" and "IDENT" in s.accepted and s.before:
        return s.recover(
            syntax.BAD_ARRAY,
            "the size of an array follows the name",
            "write TYPE NAME[SIZE], or sequence<TYPE> NAME if the size varies",
        )
    if s.text == "[" and not s.before:
        return _foreign(s, "annotations are not written in brackets", "write @name")
    if s.text == "]" and s.previous == "[":
        return s.recover(
            syntax.BAD_ARRAY,
            "an array has a size",
            "write NAME[SIZE], or sequence<TYPE> NAME if the size varies",
            at=(s.before[-1].start, s.end),
        )
    if s.text == "," and "RSQB" in s.accepted:
        return s.recover(
            syntax.BAD_ARRAY,
            "each dimension has its own brackets",
            "write NAME[2][3]",
        )
    return None


def parenthesis(s: ErrorContext) -> Recovery | None:
    """Recognize parentheses in place of angle brackets, and bases in parentheses."""
    if s.text != "(":
        return None
    if s.previous in ("sequence", "string", "wstring", "fixed", "map"):
        return s.recover(
            syntax.MISSING_MARK,
            f"'{s.previous}' requires '<' and '>', not '(' and ')'",
            f"write {s.previous}<...>",
        )
    if s.first in ("interface", "struct", "valuetype") and "COLON" in s.accepted:
        return s.recover(
            syntax.UNEXPECTED,
            "a base follows ':'",
            f"write {s.first} {s.previous} : {s.following}",
        )
    return None


def operators(s: ErrorContext) -> Recovery | None:
    """Recognize `*`, `&`, `&&` and other operators of other languages."""
    if s.text in ("*", "&") and "IDENT" in s.accepted and "NUMBER" not in s.accepted:
        hint = (
            "write string for text, sequence<T> for several, inout or out for a result"
        )
        return _foreign(s, "IDL has no pointers and references", hint)
    if s.text[:1] in ("&", "|") and s.previous[:1] == s.text[:1]:
        return _foreign(
            s, "IDL has no logical operators", "boolean constants are TRUE or FALSE"
        )
    if s.text == "*" and s.previous == "*":
        return _foreign(s, "IDL has no powers", "write the number, or a product")
    return None


def names_and_colons(s: ErrorContext) -> Recovery | None:
    """Recognize marks within names, and a `:` that is missing or stands for another mark."""
    if (
        s.first == "case"
        and "COLON" in s.accepted
        and (s.text in RESERVED or s.kind == "IDENT")
    ):
        return s.missing(":", f"put ':' after '{s.previous}'", feed="COLON")
    if s.text[:1] in ("-", "/") and s.unit.text[s.last : s.start] == "":
        if "IDENT" in s.accepted and "NUMBER" not in s.accepted and s.before:
            return s.recover(
                syntax.UNEXPECTED,
                f"'{s.text}' is not allowed in a name",
                "parts of a name are joined by ::",
            )
        if s.before and s.before[-1].is_name and s.following:
            return s.recover(
                syntax.UNEXPECTED,
                f"'{s.text}' is not allowed in a name",
                f"write {s.previous}_{s.following}",
            )
    if s.text == ":" and "IDENT" in s.accepted and s.before and s.before[-1].is_name:
        return s.recover(
            syntax.UNEXPECTED,
            "one ':' is not allowed in a name",
            "parts of a name are joined by ::",
        )
    if (
        s.text == ":"
        and "SEMI" in s.accepted
        and s.construct in ("struct", "exception")
    ):
        if s.following.isdigit():
            hint = "bit fields belong in a bitset: bitfield<3> NAME;"
            return _foreign(s, "members of a struct have no width in bits", hint)
        return s.recover(
            syntax.MISSING_SEMICOLON,
            "a ';' is expected here, not a ':'",
            "each member ends with ';'",
            feed=("SEMI",),
            instead=True,
        )
    return None


def marks(s: ErrorContext) -> Recovery | None:
    """Recognize other comments, a mark too many, and what stands in place of a name or a type."""
    if s.text in ("-", "<") and not s.before and s.following in ("-", "!"):
        return _foreign(s, "this is not a comment in IDL", "write // ... or /* ... */")
    if s.text == ">" and s.previous == ">":
        return s.recover(
            syntax.UNEXPECTED, "this '>' closes nothing", "remove it", instead=True
        )
    if s.text == "{" and not s.before and s.last and s.unit.text[s.last - 1] == ";":
        declared = header(s.unit.text, s.last - 1)
        s.unit.maybe_declared.update(word.text.lower() for word in declared)
        return s.recover(
            syntax.UNEXPECTED,
            "this ';' cuts the body off",
            "remove it",
            at=(s.last - 1, s.last),
        )
    is_word = s.text[:1].isdigit() and any(c.isalpha() for c in s.text)
    if is_word and "IDENT" in s.accepted and "NUMBER" not in s.accepted:
        return s.recover(
            syntax.UNEXPECTED,
            f"'{s.text}' is not a name: it begins with a digit",
            "a name begins with a letter",
        )
    if s.kind == "NUMBER" and s.previous == "<" and "NUMBER" not in s.accepted:
        return s.recover(
            syntax.UNEXPECTED,
            "the type comes first, then the bound",
            "write sequence<TYPE, BOUND>",
        )
    return None


def words_of_constructs(s: ErrorContext) -> Recovery | None:
    """Recognize a missing `switch` or `attribute`, and a switch with a name."""
    if s.text == "{" and "SWITCH" in s.accepted:
        return s.recover(
            syntax.MISSING_WORD,
            "'switch (TYPE)' is missing here",
            "a union selects its branches by a value: union U switch (long) { case 1: ... }",
            after_last=True,
        )
    if s.kind == "IDENT" and "RPAR" in s.accepted and s.first == "union":
        return s.recover(
            syntax.UNEXPECTED,
            "the switch of a union has no name",
            f"write switch ({s.previous})",
        )
    if s.text in RESERVED and s.previous == "readonly":
        return s.recover(
            syntax.MISSING_WORD,
            "'attribute' is missing after 'readonly'",
            "write readonly attribute TYPE NAME;",
            feed=("ATTRIBUTE",),
            resume=s.start,
        )
    return None
