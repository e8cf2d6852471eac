"""The types of a module's `IDL` with numbers in each form."""

from __future__ import annotations

from typing import Any

import emitted
import pytest

from rtgen.facts.numeric import Numeric


@pytest.fixture(scope="module")
def packages(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[Numeric, Any]:
    """Generate the types of the IDL module `n`."""
    return emitted.in_each_form(tmp_path_factory, request.module.IDL)


@pytest.fixture(scope="module")
def arrays(packages: dict[Numeric, Any]) -> Any:
    return packages["array"]
