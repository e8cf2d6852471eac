"""Builds the wheel and runs the fast tests on it with another interpreter.

One of those found, chosen by the commit, so that commits try them in turn; `--all` tries each.
Of the tests a quarter, chosen by the seed, unless the budget is for all (`seeds`).
`--lowest` uses this interpreter and the lowest versions that pyproject.toml allows. `--install`
makes the environments alone, `--installed` runs the tests in those that were made. `--version`
prints which of all versions the commit is type-checked for.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import environments
from seeds import commit, is_for_all

SUPPORTED = ("3.11", "3.12", "3.13")
ROOT = Path(__file__).resolve().parent.parent

MONITORED = ("3.12", "3.13")
"""Versions that can measure line coverage at hardly any cost."""

PROCESSES = "2"
"""Number of parallel test processes."""

SELECTED = "not slow and not peer and not random and not postponed and (left_out or not nightly)"
"""The markers of the tests that are tried on further interpreters: all cases of sampled ones."""

ENVIRONMENTS = ROOT / "build" / "interpreters"

TRIED_ONCE = (
    "tests/interop",
    "tests/fuzz",
    "tests/tools/packages",
    "tests/compiler/texts/test_catalogue.py",
    "tests/compiler/test_circles.py",
    "tests/test_sources.py",
)
"""Comparisons with peers, random inputs and the sources are the same on each interpreter.

In other folders they have the markers `peer` and `random`.
"""


def find(version: str) -> str | None:
    """The path of a working interpreter of that version, on the path or of pyenv, or None."""
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    candidates = [shutil.which(f"python{version}")]
    candidates += map(
        str, sorted(pyenv.glob(f"versions/{version}.*/bin/python{version}"))
    )
    code = "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"
    for candidate in filter(None, candidates):
        answer = subprocess.run(
            [candidate, "-c", code], capture_output=True, text=True, check=False
        )
        if answer.stdout.strip() == version:
            return candidate
    return None


def make(interpreter: str, folder: Path, *, lowest: bool = False) -> None:
    """An environment of its own for an interpreter, with both wheels and the reference build.

    `lowest`: with the lowest versions of the requirements, which uv finds.
    """
    shutil.rmtree(folder, ignore_errors=True)
    python = environments.create(interpreter, folder)
    wheel = environments.build_wheel(ROOT, folder / "wheels")
    runtime = environments.build_wheel(ROOT / "runtime", folder / "wheels" / "runtime")
    requirements = (str(runtime), f"{wheel}[plot,test]")
    if lowest:
        # pip has no such resolution.
        uv = [str(environments.UV), "pip", "install", "--quiet", "--python", python]
        uv += ["--resolution", "lowest-direct", *requirements]
        subprocess.run(uv, check=True)
    else:
        environments.install(python, *requirements)
    _install_application(python, folder)


def run_tests(folder: Path, *, measured: bool) -> tuple[int, str]:
    """The exit code and output of the fast tests in an environment.

    `measured`: with the coverage of lines, of which all of them are needed.
    """
    python = str(folder / "bin" / "python")
    tests = [python, "-m", "pytest", "-q", "-o", f"cache_dir={folder / 'cache'}"]
    tests += ["-m", SELECTED, "-n", PROCESSES, "--dist", "worksteal"]
    tests += [f"--ignore={name}" for name in TRIED_ONCE]
    measuring = ["--cov", "--cov-report=term:skip-covered"] * measured
    environment = {
        **os.environ,
        **({"COVERAGE_CORE": "sysmon"} if measured else {}),
        "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
    }
    # Assertions that show their values take half a minute to be compiled: only what fails has them.
    run = _printed([*tests, *measuring, "--assert=plain"], environment)
    if run.returncode == 0:
        return 0, run.stdout
    judge = [python, "tests/unsteady.py", str(run.returncode), str(folder / "cache")]
    judged = _printed(judge, environment)
    return judged.returncode, f"{run.stdout}\n{judged.stdout}"


def _install_application(python: str, folder: Path) -> None:
    """Makes the reference build importable, as its editable install does, but not `src/rtgen`."""
    (folder / "application").mkdir()
    (folder / "application" / "refnav").symlink_to(ROOT / "reference" / "refnav")
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    place = subprocess.run(
        [python, "-c", code], check=True, capture_output=True, text=True
    )
    file = Path(place.stdout.strip()) / "reference.pth"
    file.write_text(f"{folder / 'application'}\n{ROOT / 'generated'}\n")


def _printed(
    command: Sequence[str], environment: dict[str, str]
) -> subprocess.CompletedProcess[str]:
    """The result of a command at the root of the tree, with all that it prints as its output."""
    return subprocess.run(
        command,
        cwd=ROOT,
        env=environment,
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def chosen(found: Sequence[str], commit: str | None) -> str:
    """The version that this commit is tried on, the first without a commit."""
    return found[int((commit or "0")[:8], 16) % len(found)]


def main() -> int:
    """Exit code 0 if the tests pass on the interpreter of this commit, or as the options say.

    The one that runs this has had them already, so the wheel is tried on it only if there is no
    other.
    """
    if "--version" in sys.argv[1:]:
        print(chosen(SUPPORTED, commit()))
        return 0
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    if "--lowest" in sys.argv[1:]:
        folder = ENVIRONMENTS / "lowest"
        make(sys.executable, folder, lowest=True)
        code, output = run_tests(folder, measured=False)
        print(f"Python {own}, lowest requirements: the fast tests\n{output}")
        return code
    found = {
        version: path
        for version in SUPPORTED
        if version != own and (path := find(version)) is not None
    }
    for version in SUPPORTED:
        if version not in (own, *found) and "--installed" not in sys.argv[1:]:
            print(f"Python {version}: not found, not tested", flush=True)
    found = found or {own: sys.executable}
    tried = list(found) if "--all" in sys.argv[1:] else [chosen([*found], commit())]
    failed = []
    for version in tried:
        folder = ENVIRONMENTS / version
        if "--installed" not in sys.argv[1:]:
            make(found[version], folder)
        if "--install" in sys.argv[1:]:
            continue
        code, output = run_tests(folder, measured=version in MONITORED and is_for_all())
        print(f"Python {version}: the fast tests on the wheel\n{output}", flush=True)
        if code != 0:
            failed.append(version)
    for version in failed:
        print(f"Python {version}: FAILED", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
