"""The emitted package with the types it needs: it imports, type-checks, and runs."""

import importlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from component_models import DOUBLE, MODE, OPTIONS, component, model, parameter, port
from type_checkers import check_by_mypy

from rtgen.compiler.backends import Owner
from rtgen.compiler.backends.components.backend import BACKEND
from rtgen.compiler.backends.types.backend import BACKEND as TYPES
from rtgen.runtime import RTC_OK, LifeCycleState, SimulatedClock, System

SOURCE = component(
    port("outport", "status", identifier="status_out"),
    port("inport", "status", identifier="status_in"),
    port("provider", "brake", "Safety::Brake", port="Safety"),
    parameter("01_x", DOUBLE, 0.5, identifier="x", minimum=0.0, maximum=2.0),
    parameter("mode", MODE),
    doc="Writes and reads.",
    rate=100.0,
)
USER = component(
    port("consumer", "brake", "Safety::Brake", port="Safety"),
    name="Watcher",
    rate=100.0,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the package `robots` and the skeletons in `behaviours`."""
    target = tmp_path_factory.mktemp("emitted")
    found = model(SOURCE, USER)
    for backend in (TYPES, BACKEND):
        for artifact in backend.emit(found, OPTIONS).artifacts:
            below = target / "behaviours" if artifact.owner is Owner.USER else target
            path = below / artifact.path
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(artifact.text, encoding="utf-8")
    (target / "behaviours/__init__.py").touch()
    return target


@pytest.fixture
def behaviours(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[dict[str, ModuleType]]:
    """Import the modules of the skeletons, by name."""
    monkeypatch.syspath_prepend(str(folder))
    forget_packages()  # Those of another test, too.
    yield {
        n: importlib.import_module(f"behaviours.{n}") for n in ("limiter", "watcher")
    }
    forget_packages()


def forget_packages() -> None:
    for name in list(sys.modules):
        if name.split(".")[0] in ("behaviours", "robots"):
            del sys.modules[name]


def test_it_runs(behaviours: dict[str, ModuleType]) -> None:
    class Limiter(behaviours["limiter"].Limiter):  # type: ignore[name-defined]
        def on_execute(self, ec_id: int) -> int:
            self.status_out.write(self.sample)
            return RTC_OK

    limiter = Limiter("Limiter0")
    reader = behaviours["limiter"].Limiter("Limiter1")
    types = importlib.import_module("robots.rtc")
    limiter.sample = types.TimedLong(data=7)
    system = System(SimulatedClock())
    for each in (limiter, reader):
        system.add(each)
    system.connect(("Limiter0", "status"), ("Limiter1", "status"), {})
    system.configure("Limiter0", "01_x", "1.5")
    assert system.activate("Limiter0") is RTC_OK
    system.run(until_ns=100_000_000)
    assert system.state("Limiter0") is LifeCycleState.ACTIVE_STATE
    assert limiter.config.x == 1.5
    assert limiter.config.mode.name == "CLIP"
    assert reader.status_in.read().data == 7
    system.close()


def test_service_calls_reach_the_servant_of_the_skeleton(
    behaviours: dict[str, ModuleType],
) -> None:
    limiter, watcher = behaviours["limiter"].Limiter(), behaviours["watcher"].Watcher()
    errors = importlib.import_module("rtgen.runtime.services.servants")
    system = System(SimulatedClock())
    for each in (limiter, watcher):
        system.add(each)
    system.connect(("Watcher0", "Safety"), ("Limiter0", "Safety"), {})
    with pytest.raises(errors.ObjectNotExist):
        watcher.brake.object.engage(1.0, "me")
    system.activate("Limiter0")
    system.run(until_ns=20_000_000)
    with pytest.raises(errors.UnknownException):
        watcher.brake.object.engage(1.0, "me")
    system.close()


def test_profile_is_that_of_the_definition(behaviours: dict[str, ModuleType]) -> None:
    profile = behaviours["limiter"].Limiter.profile
    assert (profile.type_name, profile.rate) == ("Limiter", 100.0)
    assert [(p.name, p.python_name, p.kind) for p in profile.ports] == [
        ("status", "status_out", "outport"),
        ("status", "status_in", "inport"),
        ("brake", "brake", "provider"),
    ]
    assert [
        (p.name, p.python_name, p.type, p.default) for p in profile.configuration
    ] == [
        ("01_x", "x", "double", "0.5"),
        ("mode", "mode", "Safety::Mode", "CLIP"),
    ]


def test_importing_it_loads_nothing_of_the_compiler(folder: Path) -> None:
    code = (
        "import sys, behaviours.limiter, behaviours.watcher\n"
        "bad = {'lark', 'jinja2', 'black', 'lxml', 'rtgen.model'} & set(sys.modules)\n"
        "assert not bad, bad\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=folder, check=True)


@pytest.mark.slow
def test_mypy_strict(folder: Path) -> None:
    check_by_mypy([folder / "robots", folder / "behaviours"], [folder])
