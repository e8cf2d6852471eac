"""Kinds of changes of IDL types (DIF01..); what breaks on the wire is compared for each type."""

from __future__ import annotations

from rtgen.diff.changes import Break, Kind, Wire

_SOURCE = (Break.SOURCE,)
_BOTH = (Break.SOURCE, Break.STORED)
_NONE: tuple[Break, ...] = ()

TYPE_ADDED = Kind("DIF0101", "type added", _NONE, "no code used the type before")
TYPE_REMOVED = Kind(
    "DIF0102", "type removed", _BOTH, "code and logs of the type have no class any more"
)
TYPE_RENAMED = Kind(
    "DIF0103",
    "type renamed",
    _BOTH,
    "octets of a value hold no name, but code, repository ids, DDS topics and logs name the type",
    (Wire.GIOP,),
)
TYPE_KIND = Kind(
    "DIF0104",
    "declaration of another kind",
    _BOTH,
    "values of the two kinds have nothing in common",
    (Wire.CDR, Wire.XCDR1, Wire.XCDR2),
)
REPOSITORY_ID = Kind(
    "DIF0105",
    "repository id changed",
    _NONE,
    "CORBA peers compare repository ids, not names",
    (Wire.GIOP,),
)
MEMBER_ADDED = Kind(
    "DIF0110",
    "member added",
    _NONE,
    "a reader of a final type needs exactly its members; appendable types take further members "
    "at their end, mutable ones anywhere",
)
MEMBER_INSERTED = Kind(
    "DIF0111",
    "member inserted",
    _SOURCE,
    "the offset of each later member changes, and its position in constructors",
)
MEMBER_REMOVED = Kind(
    "DIF0112",
    "member removed",
    _BOTH,
    "code and stored values that name the member find it no more",
)
MEMBER_RENAMED = Kind(
    "DIF0113",
    "member renamed",
    _BOTH,
    "the octets are the same, but code and stored values name the member",
)
MEMBERS_REORDERED = Kind(
    "DIF0114",
    "members in another order",
    _SOURCE,
    "only mutable types find their members by id; constructors take them in order",
)
MEMBER_TYPE = Kind(
    "DIF0115",
    "member of another type",
    _BOTH,
    "a reader interprets the octets as a value of its own type",
)
MEMBER_ALIAS = Kind(
    "DIF0116",
    "member of the same type by another name",
    _NONE,
    "a typedef has the octets and values of its type",
)
BOUND_RAISED = Kind(
    "DIF0117",
    "bound raised or removed",
    _NONE,
    "readers of the old version refuse more than their bound",
)
BOUND_LOWERED = Kind(
    "DIF0118",
    "bound lowered or added",
    _BOTH,
    "values that were valid are refused by encoders and readers of the new version",
)
DIMENSIONS = Kind(
    "DIF0119",
    "array of another size",
    _BOTH,
    "arrays are encoded without length, so the offsets of all later members change",
)
OPTIONAL = Kind(
    "DIF0120",
    "member made optional or required",
    _SOURCE,
    "an optional member has a flag or header, and may be None",
)
MEMBER_ID = Kind(
    "DIF0121",
    "member id changed",
    _NONE,
    "readers find members of mutable types, and optional ones in XCDR1, by id",
)
MEMBER_ID_REUSED = Kind(
    "DIF0122",
    "member id reused",
    _NONE,
    "readers take the octets of the new member for those of the removed one",
)
KEY = Kind(
    "DIF0123",
    "member added to or removed from the key",
    _NONE,
    "key hashes identify the instances of a DDS topic",
    (Wire.KEY,),
)
MUST_UNDERSTAND = Kind(
    "DIF0124",
    "must_understand changed",
    _NONE,
    "only a reader without the member refuses the value, and both versions have it",
)
EXTERNAL = Kind(
    "DIF0125",
    "external changed",
    _SOURCE,
    "whether the member can be unset is part of its Python type",
)
TRY_CONSTRUCT = Kind(
    "DIF0126",
    "try_construct changed",
    _SOURCE,
    "DDS readers discard, trim or replace a value that does not fit, as the annotation says",
)
EXTENSIBILITY = Kind(
    "DIF0127",
    "extensibility changed",
    _NONE,
    "the extensibility decides on headers of the type and of its members",
)
BASE = Kind(
    "DIF0128",
    "base struct changed",
    _SOURCE,
    "code that uses a value as one of its base finds another class",
)
NESTED = Kind(
    "DIF0129",
    "nested changed",
    _NONE,
    "only whether DDS makes a topic of the type depends on it",
)
REPRESENTATION = Kind(
    "DIF0130",
    "data representation changed",
    (Break.STORED,),
    "to_cdr writes, and logs hold, another representation",
    (Wire.CDR,),
)
MEMBER_UNIT = Kind(
    "DIF0131",
    "unit of a member changed",
    _BOTH,
    "the same number means another quantity",
)
MEMBER_RANGE_NARROWED = Kind(
    "DIF0132",
    "range of a member narrowed",
    _SOURCE,
    "values that were valid are not any more",
)
MEMBER_RANGE_WIDENED = Kind(
    "DIF0133",
    "range of a member widened",
    _NONE,
    "valid values stay valid",
)
MEMBER_DEFAULT = Kind(
    "DIF0134",
    "default of a member changed",
    _SOURCE,
    "code that sets no value gets another one",
)
NUMERIC = Kind(
    "DIF0135",
    "form of numbers in Python changed",
    _SOURCE,
    "lists, arrays and numpy arrays have other operations",
)
CASE_ADDED = Kind(
    "DIF0140",
    "branch added to a union",
    _SOURCE,
    "old readers have no branch for the new discriminator, and code has to treat one more",
)
CASE_REMOVED = Kind(
    "DIF0141",
    "branch removed from a union",
    _BOTH,
    "values with its discriminator cannot be read as before",
)
CASE_RENAMED = Kind(
    "DIF0142",
    "branch of a union renamed",
    _BOTH,
    "the octets are the same, but code and stored values name the branch",
)
CASE_LABELS = Kind(
    "DIF0143",
    "labels of a branch changed",
    _SOURCE,
    "a discriminator selects another branch",
)
CASE_DEFAULT = Kind(
    "DIF0144",
    "default branch changed",
    _SOURCE,
    "discriminators without a label select another branch",
)
CASE_ID = Kind(
    "DIF0145",
    "id of a branch changed",
    _NONE,
    "readers of mutable unions find branches by id",
)
SWITCH = Kind(
    "DIF0146",
    "discriminator of another type",
    _SOURCE,
    "readers take the discriminator for a value of their own type",
)
ENUMERATOR_ADDED = Kind(
    "DIF0150",
    "enumerator added",
    _SOURCE,
    "old readers refuse the number, and code for each enumerator does not handle it",
)
ENUMERATOR_REMOVED = Kind(
    "DIF0151",
    "enumerator removed",
    _BOTH,
    "new readers refuse the number, and code and stored values name it",
)
ENUMERATOR_RENAMED = Kind(
    "DIF0152",
    "enumerator renamed",
    _BOTH,
    "the number is the same, but code and stored values name the enumerator",
)
ENUMERATOR_NUMBER = Kind(
    "DIF0153",
    "enumerator renumbered",
    (Break.STORED,),
    "the number on the wire and in logs means another enumerator",
)
BIT_BOUND = Kind(
    "DIF0154",
    "bit bound changed",
    _NONE,
    "the bound decides on the octets of a value",
)
FLAG_ADDED = Kind(
    "DIF0155", "flag added", _NONE, "readers keep flags that they do not know"
)
FLAG_REMOVED = Kind(
    "DIF0156", "flag removed", _BOTH, "code and stored values name the flag"
)
FLAG_RENAMED = Kind(
    "DIF0157",
    "flag renamed",
    _BOTH,
    "the bit is the same, but code and stored values name it",
)
FLAG_POSITION = Kind(
    "DIF0158",
    "flag at another position",
    (Break.STORED,),
    "the bit on the wire and in logs means another flag",
)
BITFIELDS = Kind(
    "DIF0159",
    "bit fields changed",
    _BOTH,
    "a reader interprets the bits as other fields",
)
TYPEDEF = Kind(
    "DIF0160",
    "typedef of another type",
    _BOTH,
    "everything of the typedef's type has another type",
)
CONST_VALUE = Kind(
    "DIF0161",
    "constant of another value",
    _SOURCE,
    "code that was built with the old value disagrees with its peers",
)
CONST_TYPE = Kind(
    "DIF0162",
    "constant of another type",
    _SOURCE,
    "expressions with the constant have another type",
)
ANNOTATION = Kind(
    "DIF0163",
    "annotation changed",
    _NONE,
    "rtgen makes nothing of the annotation; other tools may",
)

KINDS = (
    TYPE_ADDED,
    TYPE_REMOVED,
    TYPE_RENAMED,
    TYPE_KIND,
    REPOSITORY_ID,
    MEMBER_ADDED,
    MEMBER_INSERTED,
    MEMBER_REMOVED,
    MEMBER_RENAMED,
    MEMBERS_REORDERED,
    MEMBER_TYPE,
    MEMBER_ALIAS,
    BOUND_RAISED,
    BOUND_LOWERED,
    DIMENSIONS,
    OPTIONAL,
    MEMBER_ID,
    MEMBER_ID_REUSED,
    KEY,
    MUST_UNDERSTAND,
    EXTERNAL,
    TRY_CONSTRUCT,
    EXTENSIBILITY,
    BASE,
    NESTED,
    REPRESENTATION,
    MEMBER_UNIT,
    MEMBER_RANGE_NARROWED,
    MEMBER_RANGE_WIDENED,
    MEMBER_DEFAULT,
    NUMERIC,
    CASE_ADDED,
    CASE_REMOVED,
    CASE_RENAMED,
    CASE_LABELS,
    CASE_DEFAULT,
    CASE_ID,
    SWITCH,
    ENUMERATOR_ADDED,
    ENUMERATOR_REMOVED,
    ENUMERATOR_RENAMED,
    ENUMERATOR_NUMBER,
    BIT_BOUND,
    FLAG_ADDED,
    FLAG_REMOVED,
    FLAG_RENAMED,
    FLAG_POSITION,
    BITFIELDS,
    TYPEDEF,
    CONST_VALUE,
    CONST_TYPE,
    ANNOTATION,
)
