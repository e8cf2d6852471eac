"""Generated interfaces: servant, stub and skeleton in one process."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import emitted
import pytest

from rtgen.runtime.services.servants import (
    BadOperation,
    ObjectNotExist,
    Servant,
    ServiceError,
    UnknownException,
)

CASE = Path(__file__).with_name("constructs.idl")


@pytest.fixture(scope="module")
def test(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return emitted.emit(tmp_path_factory.mktemp("services"), [CASE]).test


@pytest.fixture
def stub(test: Any) -> Any:
    class Servant(test.More):  # type: ignore[misc]
        rate = 2.5
        now = test.Service.Inner(test.Service.OFF)
        fired = ""

        def work(self, a: int, c: Any) -> tuple[int, str, Any]:
            if a < 0:
                raise test.Bad("negative", a)
            if a > 100:
                raise KeyError(a)
            return a + 1, "done", test.Point(c.y, c.x)

        def nop(self) -> None: ...

        def fire(self, text: str) -> None:
            self.fired = text

        def again(self, other: Any) -> Any:
            if other is None:
                raise ObjectNotExist("nobody")
            return other

        def add(self, *lists: list[int]) -> None:
            self.rate = float(sum(lists[0]))

    skeleton = test.More._skeleton_(Servant())
    return test.More._stub_(skeleton.dispatch)


def test_results_follow_omniorbpy(test: Any, stub: Any) -> None:
    assert stub.work(1, test.Point(2.0, 3.0)) == (2, "done", test.Point(3.0, 2.0))
    assert stub.nop() is None
    assert stub.again(stub) is stub


def test_attributes_are_operations(stub: Any) -> None:
    assert stub.rate == 2.5
    stub.rate = 4.0
    assert stub.rate == 4.0
    with pytest.raises(AttributeError):
        stub.now = None


def test_inherited_and_own_operations(stub: Any) -> None:
    stub.add([1, 2])
    assert stub.rate == 3.0


def test_declared_exceptions_pass(test: Any, stub: Any) -> None:
    with pytest.raises(test.Bad) as caught:
        stub.work(-1, test.Point())
    assert caught.value.args_ == -1


def test_other_exceptions_are_unknown(test: Any, stub: Any) -> None:
    with pytest.raises(UnknownException, match="KeyError") as caught:
        stub.work(101, test.Point())
    assert isinstance(caught.value.__cause__, KeyError)
    with pytest.raises(ObjectNotExist):
        stub.again(None)


def test_unknown_operations_and_arguments(test: Any, stub: Any) -> None:
    with pytest.raises(BadOperation, match="no operation"):
        stub._invoker("fly", ())
    with pytest.raises(BadOperation, match="takes 2 arguments, not 1"):
        stub._invoker("work", (1,))
    assert issubclass(BadOperation, ServiceError)


def test_a_servant_has_to_implement_everything(test: Any) -> None:
    assert issubclass(test.More, Servant)
    with pytest.raises(TypeError, match="abstract"):
        test.Service()


def test_what_is_declared_inside_is_an_attribute(test: Any) -> None:
    assert test.Service.LIMIT == 3
    assert test.Service.ON is test.Service.State.ON
    assert test.More.Inner is test.Service.Inner


def test_descriptors_know_bases(test: Any) -> None:
    assert test.More._descriptor_.is_a("IDL:Test/Service:1.0")
    assert not test.Service._descriptor_.is_a("IDL:Test/More:1.0")
