"""The annotations that rtgen knows: parameters and allowed places (OMG IDL 4.2, 8.3)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import msgspec

from rtgen.compiler.frontends.idl.names.scopes import Kind
from rtgen.compiler.model import Primitive, PrimitiveType, StringType, Type
from rtgen.facts.numeric import FORMS

TEXT = StringType()
INTEGER = PrimitiveType(Primitive.LONG_LONG)
NUMBER = PrimitiveType(Primitive.DOUBLE)
FLAG = PrimitiveType(Primitive.BOOLEAN)
WORD = "word"
"""A bare word such as FINAL, or a text."""
TYPED = "typed"
"""A value of the annotated type."""

Wanted = Type | str


class Definition(msgspec.Struct, frozen=True):
    """An annotation: its parameters, the places where it is allowed, its mandatory parameter.

    `words` are the allowed values of a word argument, by its name; without them, any.
    """

    arguments: Mapping[str, Wanted] = msgspec.field(default_factory=dict)
    places: frozenset[str] = frozenset()
    required: str = ""
    words: Mapping[str, tuple[str, ...]] = msgspec.field(default_factory=dict)


def _define(
    places: str, *, required: str = "", words: str = "", **arguments: Wanted
) -> Definition:
    return Definition(
        MappingProxyType(arguments),
        frozenset(places.split()),
        required,
        {
            key: tuple(words.split())
            for key in arguments
            if words and arguments[key] == WORD
        },
    )


_ANYWHERE = (
    "module struct exception union enum bitset bitmask typedef constant interface valuetype member"
    " case enumerator bit_value bitfield parameter operation attribute component port configuration"
)
_TYPES = "struct union enum bitset bitmask valuetype exception typedef interface"
_FIELDS = "member case bitfield typedef port configuration attribute parameter constant"

DEFINITIONS: Mapping[str, Definition] = MappingProxyType(
    {
        # OMG IDL 4.2, 8.3
        "id": _define("member case", required="value", value=INTEGER),
        "autoid": _define(_TYPES + " module", words="SEQUENTIAL HASH", value=WORD),
        "hashid": _define("member case", value=TEXT),
        "optional": _define("member", value=FLAG),
        "position": _define("bit_value bitfield", required="value", value=INTEGER),
        "value": _define("enumerator", required="value", value=INTEGER),
        "extensibility": _define(
            _TYPES + " module",
            required="value",
            words="FINAL APPENDABLE MUTABLE",
            value=WORD,
        ),
        "final": _define(_TYPES + " module"),
        "appendable": _define(_TYPES + " module"),
        "mutable": _define(_TYPES + " module"),
        "key": _define("member case attribute", value=FLAG),
        "must_understand": _define("member case", value=FLAG),
        "default_literal": _define("enumerator"),
        "default": _define(
            "member configuration case bitfield typedef attribute",
            required="value",
            value=TYPED,
        ),
        "range": _define(_FIELDS, min=TYPED, max=TYPED),
        "min": _define(_FIELDS, required="value", value=TYPED),
        "max": _define(_FIELDS, required="value", value=TYPED),
        "unit": _define(_FIELDS, required="value", value=TEXT),
        "bit_bound": _define("enum bitmask", required="value", value=INTEGER),
        "external": _define("member case", value=FLAG),
        "nested": _define(_TYPES, value=FLAG),
        "default_nested": _define("module", value=FLAG),
        "verbatim": _define(
            _ANYWHERE,
            required="text",
            words="BEGIN_FILE BEFORE_DECLARATION BEGIN_DECLARATION END_DECLARATION"
            " AFTER_DECLARATION END_FILE",
            language=TEXT,
            placement=WORD,
            text=TEXT,
        ),
        "service": _define("interface", platform=TEXT),
        "oneway": _define("operation", value=FLAG),
        "ami": _define("interface operation", value=FLAG),
        # DDS-XTypes 1.3, 7.3.1
        "topic": _define("struct union", name=TEXT, platform=TEXT),
        "data_representation": _define(
            "struct union module",
            words="XCDR XCDR1 XCDR2 XML",
            allowed_kinds=WORD,
            value=WORD,
        ),
        "try_construct": _define(
            "member case typedef", words="DISCARD USE_DEFAULT TRIM", value=WORD
        ),
        "ignore_literal_names": _define("enum", value=FLAG),
        "non_serialized": _define("member", value=FLAG),
        "transfer_mode": _define(_ANYWHERE, value=WORD),
        # rtgen's own, for components
        "rtc": _define(
            "component",
            kind=TEXT,
            category=TEXT,
            vendor=TEXT,
            version=TEXT,
            description=TEXT,
            rate=NUMBER,
            max_instances=INTEGER,
            activity=TEXT,
            execution=TEXT,
            component_type=TEXT,
            activity_type=TEXT,
            triggers=TEXT,
            created=TEXT,
            updated=TEXT,
        ),
        # rtgen's own: a type of which only the name is known
        "opaque": _define("struct interface"),
        "name": _define("port configuration component", required="value", value=TEXT),
        "port": _define("port", required="value", value=TEXT),
        "instance": _define("port", required="value", value=TEXT),
        "type_name": _define("port", required="value", value=TEXT),
        "openrtm_name": _define("port", required="value", value=TEXT),
        # RtcProfile 0.3: a port for events of a state machine, and the transitions it can cause
        "event_port": _define("port"),
        "event": _define(
            "port",
            required="name",
            name=TEXT,
            source=TEXT,
            target=TEXT,
            condition=TEXT,
            type=TEXT,
        ),
        # rtgen's own: the Python type of numbers
        "numeric": _define(
            "member case typedef",
            required="value",
            words=" ".join(FORMS).upper(),
            value=WORD,
        ),
        "widget": _define("configuration", required="value", value=TEXT),
        "constraint": _define("configuration", required="value", value=TEXT),
    }
)
"""All known annotations; `@name` and similar ones only apply to components."""

_REPEATABLE = ("verbatim", "data_representation", "event")

PLACES = {
    Kind.STRUCT: "struct",
    Kind.EXCEPTION: "exception",
    Kind.UNION: "union",
    Kind.ENUM: "enum",
    Kind.BITSET: "bitset",
    Kind.BITMASK: "bitmask",
    Kind.TYPEDEF: "typedef",
    Kind.CONST: "constant",
    Kind.INTERFACE: "interface",
    Kind.VALUETYPE: "valuetype",
    Kind.COMPONENT: "component",
}
"""The name of a place for annotations, if it differs from the kind of declaration."""
