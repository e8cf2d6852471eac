"""The program `rtgen`, also as `python -m rtgen`."""

import gc
import sys

from rtgen import __version__


def main() -> None:
    """Run the command line. `rtgen --version` imports nothing else."""
    if sys.argv[1:] == ["--version"]:
        print("rtgen", __version__)
        return
    from rtgen.cli import run

    code = run(sys.argv[1:], ends=True)
    # A collection at interpreter exit would only cost time: the process frees its memory anyway.
    gc.freeze()
    sys.exit(code)


if __name__ == "__main__":
    main()
