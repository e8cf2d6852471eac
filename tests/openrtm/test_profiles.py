"""Profiles of RTCBuilder become embedded and OpenRTM packages that import and type-check."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from type_checkers import check_by_mypy

from rtgen.cli import run

GOLDEN = Path(__file__).parents[3] / "shared" / "golden" / "rtc_profiles"
PROFILES = sorted(GOLDEN.glob("rtc/*.xml"))

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(
        not PROFILES, reason="no profiles: ../shared/golden/rtc_profiles is missing"
    ),
]


@dataclass(frozen=True)
class Made:
    """The generated packages of a profile."""

    folder: Path
    package: str
    module: Path

    @property
    def places(self) -> list[Path]:
        """The folders of the package and of the skeleton."""
        return [self.folder / "generated", self.folder / "src"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> list[Made]:
    """Generate each profile in a folder of its own."""
    found = []
    with pytest.MonkeyPatch.context() as patch:
        for number, path in enumerate(PROFILES):
            folder = tmp_path_factory.mktemp(f"p{number}")
            patch.chdir(folder)
            package = f"robots{number}"
            (folder / "rtgen.toml").write_text(
                f'[sources]\npaths = []\n[output]\npackage = "{package}"\n'
            )
            arguments = ["generate", str(path), "-q", "-o", str(folder)]
            assert (
                run([*arguments, "--target", "openrtm", "--no-cache"]) == 0
            ), path.name
            places = (folder / "generated/openrtm").iterdir()
            [module] = [p for p in places if (p / f"{p.name}.py").is_file()]
            found.append(Made(folder, package, module / f"{module.name}.py"))
    return found


def test_embedded_packages(made: list[Made]) -> None:
    code = "import sys, importlib\n"
    code += "for n, p in enumerate(sys.argv[1:]):\n    sys.path.insert(0, p)\n"
    code += "    importlib.import_module(f'robots{n}.components')\n"
    command = [sys.executable, "-c", code, *(str(each.places[0]) for each in made)]
    subprocess.run(command, check=True)


def test_modules(made: list[Made], rtm_environment: dict[str, str]) -> None:
    """The script compiles stubs. Missing IDL files have stubs of equal names."""
    for each in made:
        folder = each.module.parent
        script = ["sh", "idlcompile.sh"]
        subprocess.run(script, cwd=folder, env=rtm_environment, check=True)
        code = f"import runpy; runpy.run_path({str(each.module)!r}, run_name='tried')"
        command = [sys.executable, "-c", code]
        subprocess.run(command, env=rtm_environment, check=True)


def test_types(made: list[Made]) -> None:
    """mypy accepts no two modules of one name at a time."""
    rest = list(made)
    while rest:
        names: dict[str, Made] = {}
        for each in rest:
            names.setdefault(each.module.stem, each)
        batch = list(names.values())
        rest = [each for each in rest if each not in batch]
        places = [place for each in batch for place in each.places]
        checkable = [each.module for each in batch]
        checkable += [each.folder / "generated" / each.package for each in batch]
        check_by_mypy(checkable, places)
