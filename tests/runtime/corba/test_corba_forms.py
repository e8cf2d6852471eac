# ruff: noqa: F401, F811 (tests and their fixture from another file)
"""Every form of operation through omniORB: the tests of stubs and skeletons once more."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import forwarder
import pytest
from patience import PATIENCE, until

pytest.importorskip("omniORB", reason="omniORBpy is not installed")
sys.path.insert(0, str(Path(__file__).parents[2] / "compiler" / "types"))

import test_service_forms
from test_service_forms import (
    forms,
    test_a_context_clause_is_no_parameter,
    test_attributes,
    test_directions,
    test_exceptions,
    test_inherited_operations_go_through_the_base_skeleton,
    test_names_that_mean_something_in_python_or_here,
    test_objects_are_called_wherever_they_are,
    test_types,
    test_types_declared_inside,
)

from rtgen.runtime.cdr import CdrError
from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.services.servants import (
    BadOperation,
    MarshalError,
    ServiceError,
    UnknownException,
)

Connect = Callable[[Any, Any], Any]
serving = test_service_forms.serving


@pytest.fixture(scope="module")
def objects() -> Iterator[Objects]:
    orb = Orb()
    yield Objects(orb)
    orb.close()


@pytest.fixture(params=["in the process", "by a socket"])
def connect(objects: Objects, request: pytest.FixtureRequest) -> Iterator[Connect]:
    """Yield a function that returns a servant's stub.

    omniORB calls objects of its own process without a socket.
    """
    with ExitStack() as stack:

        def connected(interface: Any, servant: Any) -> Any:
            call = interface._skeleton_(servant).dispatch
            reference = objects.serve(interface, call)
            if request.param == "by a socket":
                imported = objects.imported(reference, None)
                imported = stack.enter_context(forwarder.forwarded(imported))
                reference = objects.exported(imported, None)
            return objects.stub(interface, reference)

        yield connected


def test_arguments_that_do_not_fit_are_reported_with_their_place(
    forms: Any, connect: Connect
) -> None:
    servant = serving(forms.Types, longs=lambda a, c: (a, 0, c, 0))
    stub = connect(forms.Types, servant)
    with pytest.raises(CdrError, match=r"^Types\.longs request\.a: "):
        stub.longs(2**31, 0)
    with pytest.raises(CdrError, match=r"^Types\.gears request\.a: "):
        stub.gears(7)
    with pytest.raises(CdrError, match=r"^Types\.prices request\.a: "):
        stub.prices(1.5)
    with pytest.raises(CdrError, match=r"^Types\.structs request\.a: "):
        stub.structs(None, [])
    with pytest.raises(CdrError, match=r"^Types\.strings request\.b: "):
        stub.strings("", "123456")
    with pytest.raises(CdrError, match=r"^Types\.lists request\.a\[0\]"):
        stub.lists([3])
    assert stub.longs(1, 2) == (1, 0, 2, 0)


def test_results_that_do_not_fit_fail_the_call(forms: Any, connect: Connect) -> None:
    servant = serving(
        forms.Directions, three=lambda: (1, 2.0), back=lambda: None, one_out=lambda: 1
    )
    stub = connect(forms.Directions, servant)
    with pytest.raises(ServiceError):
        stub.three()
    with pytest.raises(ServiceError):
        stub.back()
    assert stub.one_out() == 1


def test_failures_are_reported(forms: Any, connect: Connect, objects: Objects) -> None:
    class Servant(forms.Errors):  # type: ignore[misc]
        def one(self, which: int) -> None:
            raise (KeyError("x"), BadOperation("inner"), MarshalError("m"))[which]

        def several(self, which: int) -> int:
            return which

        def repeated(self) -> None:
            raise forms.Broken("not declared", 1)

    stub = connect(forms.Errors, Servant())
    for which, kind in enumerate((UnknownException, BadOperation, MarshalError)):
        with pytest.raises(kind):
            stub.one(which)
    with pytest.raises(UnknownException):
        stub.repeated()
    other = objects.stub(forms.Directions, objects.exported(stub, None))
    with pytest.raises(ServiceError, match=r"BAD_OPERATION|NO_IMPLEMENT"):
        other.back()


def test_a_oneway_operation_tells_nobody_of_a_failure(
    forms: Any, connect: Connect
) -> None:
    received: list[object] = []

    def fail() -> None:
        received.append("tick")
        raise KeyError("gone")

    servant = serving(forms.Signals, fire=lambda *x: received.append(x), tick=fail)
    stub = connect(forms.Signals, servant)
    assert stub.tick() is None
    assert stub.fire("now", forms.Pose(1.0, 2.0)) is None
    # Nothing is answered. omniORB may give two requests of a connection to two threads.
    until(lambda: len(received) == 2)
    assert "tick" in received
    assert ("now", forms.Pose(1.0, 2.0)) in received


def test_a_local_interface_has_no_calls(forms: Any, objects: Objects) -> None:
    with pytest.raises(ServiceError, match="Forms::Gauge is local"):
        objects.serve(forms.Gauge, lambda operation, arguments: None)
