"""Schemas of recordings, which omniidl reads as our front end does, unions included."""

from __future__ import annotations

import importlib
import pkgutil
import re
from pathlib import Path

import pytest
from idl_facts import facts, omniidl_batch
from programs import needs_omniidl

import refrobots
from rtgen.compiler.diagnostics import has_errors
from rtgen.compiler.frontends.idl import load
from rtgen.compiler.inspection.models import defined
from rtgen.runtime.marshalling.descriptors import StructDescriptor, UnionDescriptor
from rtgen.tools.recording.schemas import schema_of

pytestmark = [needs_omniidl, pytest.mark.nightly]

ANNOTATION = re.compile(r"@\w+(\([^)]*\))? *")
"""omniidl has no annotations."""


def schemas() -> dict[str, str]:
    """Return the schemas of every struct and union of the reference build, by name."""
    found = {}
    for module in pkgutil.walk_packages(refrobots.__path__, "refrobots."):
        for value in vars(importlib.import_module(module.name)).values():
            described = getattr(value, "_descriptor_", None)
            if (
                isinstance(described, StructDescriptor | UnionDescriptor)
                and "." not in described.name
            ):
                found[described.name] = schema_of(described).text
    return found


def test_omniidl_finds_the_same_declarations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = schemas()
    files = [Path(f"{number}.idl") for number in range(len(found))]
    for file, text in zip(files, found.values(), strict=True):
        file.write_text(ANNOTATION.sub("", text))
    asked: list[dict[str, object]] = [
        {"folder": str(tmp_path), "file": file.name, "arguments": []} for file in files
    ]
    unions = 0
    for file, text, theirs in zip(
        files, found.values(), omniidl_batch(asked), strict=True
    ):
        assert theirs["status"] == 0, theirs["messages"]
        file.write_text(text)
        read = load([file], root=tmp_path)
        assert not has_errors(read.diagnostics), read.diagnostics
        ours = [facts(each) for each in defined(read.model.declarations)]
        assert {str(f["name"]): f for f in ours} == {
            str(f["name"]): f for f in theirs["facts"]
        }
        unions += "union " in text
    assert len(files) > 150
    assert unions
