"""The names of the runtime's classes, as behaviours may use them."""

from __future__ import annotations

from inspect import getsource

import pytest

from rtgen.compiler.project import behaviour_classes, behaviour_uses
from rtgen.runtime import Component, Configuration, Consumer, InPort, OutPort, Provider
from rtgen.runtime.canopen.configuration import DeviceConfiguration, ProxyConfiguration
from rtgen.runtime.canopen.master.proxy import CanopenProxy
from rtgen.runtime.canopen.node.device import CanopenDevice

CLASSES = [
    *(Component, Configuration, Consumer, InPort, OutPort, Provider),
    *(DeviceConfiguration, ProxyConfiguration, CanopenProxy, CanopenDevice),
]


@pytest.mark.parametrize("class_", CLASSES)
def test_the_source_of_a_class_is_found_without_a_syntax_tree(class_: type) -> None:
    for base in class_.__mro__:
        if base.__module__.startswith("rtgen."):
            whole = getsource(base)
            whole = whole[whole.index(f"class {base.__name__}") :]
            assert behaviour_classes._source(base).rstrip() == whole.rstrip()


def test_names_that_instances_set_are_known() -> None:
    names = behaviour_classes._runtime_names("rtgen.runtime", "Component")
    assert names is not None
    assert {"instance_name", "folder", "on_execute", "reason"} <= names
    assert "on_executed" not in names


@pytest.mark.parametrize(("module", "name"), behaviour_classes.PUBLIC)
def test_names_known_without_the_class_are_its_own(module: str, name: str) -> None:
    names = behaviour_classes._runtime_names(module, name)
    assert names is not None
    assert names >= {*behaviour_classes.PUBLIC[module, name]}


@pytest.mark.parametrize(
    ("kind", "class_"),
    [
        ("inport", InPort),
        ("outport", OutPort),
        ("provider", Provider),
        ("consumer", Consumer),
    ],
)
def test_names_known_of_ports_are_their_own(kind: str, class_: type) -> None:
    names = behaviour_classes._runtime_names("rtgen.runtime", class_.__name__)
    assert names is not None
    assert names >= {*behaviour_uses._USED[kind]}
