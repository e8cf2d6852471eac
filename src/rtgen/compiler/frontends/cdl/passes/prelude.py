"""Scalar types of TOPPERS kernels' headers, known without an import."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from rtgen.compiler.model.c_types import CPointerType, CScalarType, CType, CTypedefType
from rtgen.facts.tdr import Scalar

_BASIC = {
    Scalar.INT: "int_t",
    Scalar.UINT: "uint_t",
    Scalar.SHORT: "short_t",
    Scalar.USHORT: "ushort_t",
    Scalar.LONG: "long_t",
    Scalar.ULONG: "ulong_t",
    Scalar.INTPTR: "intptr_t",
    Scalar.UINTPTR: "uintptr_t",
}
_DERIVED = {
    "int_t": "ER ER_BOOL ER_ID ER_UINT ER_INT ID PRI INTPRI TMO FN",
    "uint_t": "ATR STAT MODE FLGPTN RDVPTN TEXPTN RELTIM OVRTIM INHNO INTNO EXCNO",
    "ulong_t": "SYSTIM SYSUTM",
    "intptr_t": "EXINF",
}


def _all_types() -> dict[str, CType]:
    found: dict[str, CType] = {name: CScalarType(kind) for kind, name in _BASIC.items()}
    for base, names in _DERIVED.items():
        for name in names.split():
            found[name] = CTypedefType((base,), found[base])
    found["SIZE"] = CScalarType(Scalar.ULONG)
    found["size_t"] = CScalarType(Scalar.ULONG)
    found["VP"] = CPointerType(CScalarType(Scalar.VOID))
    return found


TYPES: Mapping[str, CType] = MappingProxyType(_all_types())
"""The types by name, as on the kernels ASP, ASP3, HRP and FMP."""
