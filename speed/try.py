"""Tries an installed rtgen-speed: the types of OpenRTM are encoded, decoded and copied in C."""

from __future__ import annotations

import os

os.environ["RTGEN_CODEC"] = "c"

from rtgen.runtime.library._idl import basic_data_type, extended_data_types
from rtgen.runtime.marshalling.compiler import compiled_in_python

found = [*vars(basic_data_type).values(), *vars(extended_data_types).values()]
types = {t for t in found if isinstance(t, type) and hasattr(t, "_descriptor_")}
for type_ in types:
    value = type_()
    described = type_._descriptor_
    octets = value.to_cdr()
    assert "in C" in repr(type_.to_cdr), type_
    assert octets == compiled_in_python("to_cdr", described)(value), type_
    assert type_.from_cdr(octets) == value == value._snapshot_(), type_
    assert type_.from_xcdr2(value.to_xcdr2()) == value, type_
print(f"{len(types)} types in C")
