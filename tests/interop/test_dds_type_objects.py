"""Type objects of random topic types equal those that cyclonedds derives from its own classes.

The hash of a type object covers names, member ids, flags and types, as other participants compare
them (DDS-XTypes 1.3, 7.3.1.2.1). Not compared are maps and unions by char, for which cyclonedds has
none, recursive types, for which rtgen has none, and structs with a base, which contain its members.
"""

from __future__ import annotations

import dds_types as dds
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from seeds import budget

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed")

from test_xcdr2_cyclonedds import sides

from rtgen.runtime.dds.types import idl_class
from rtgen.runtime.distribution.medium import MediumError

CHAR = dds.Basic("char")


@settings(
    max_examples=budget(15),
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.generate],
)
@given(declared=dds.type_sets())
def test_random_types_have_the_same_type_objects(
    tmp_path_factory: pytest.TempPathFactory, declared: tuple[dds.Declared, ...]
) -> None:
    pair = sides(tmp_path_factory.mktemp("set"), declared)
    for type_ in declared:
        if isinstance(type_, dds.Struct | dds.Union):
            ours = getattr(pair.ours, type_.name)
            if any(isinstance(part, dds.Map | dds.Self) for part in dds.parts(type_)):
                with pytest.raises(MediumError, match="cannot be sent over DDS"):
                    idl_class(ours)
                continue
            if any(getattr(part, "base", None) for part in dds.parts(type_)):
                continue
            if any(getattr(part, "switch", None) == CHAR for part in dds.parts(type_)):
                assert idl_class(ours).__idl__.get_type_id()
                continue
            theirs = getattr(pair.theirs, type_.name)
            assert idl_class(ours).__idl__.get_type_id() == theirs.__idl__.get_type_id()
