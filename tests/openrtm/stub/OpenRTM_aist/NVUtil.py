"""Properties for transfer: lists of name and value, all values texts."""

from __future__ import annotations

from typing import Any

import SDOPackage
from omniORB import any as omni_any

from .properties import Properties


def newNV(name: str, value: Any) -> Any:
    return SDOPackage.NameValue(name, omni_any.to_any(value))


def copyToProperties(prop: Properties, nv: list[Any]) -> None:
    for item in nv:
        value = omni_any.from_any(item.value)
        if isinstance(value, str):
            prop.setProperty(item.name, value)


def copyFromProperties(nv: list[Any], prop: Properties) -> None:
    nv[:] = [newNV(key, prop.getProperty(key)) for key in prop.propertyNames()]


def toString(nv: list[Any], name: str) -> str:
    for item in nv:
        if item.name == name:
            value = omni_any.from_any(item.value)
            return value if isinstance(value, str) else ""
    return ""


def properties_of(nv: list[Any]) -> Properties:
    """Return a new tree with the texts of a list."""
    prop = Properties()
    copyToProperties(prop, nv)
    return prop


def list_of(prop: Properties) -> list[Any]:
    """Return a new list with the texts of a tree."""
    nv: list[Any] = []
    copyFromProperties(nv, prop)
    return nv
