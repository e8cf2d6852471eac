"""The program `rtgen`, also as `python -m rtgen`."""

import gc
import sys

from rtgen import __version__


def main() -> None:
    """Run the command line; the version alone needs none of its libraries."""
    if sys.argv[1:] == ["--version"]:
        print("rtgen", __version__)
        return
    from rtgen.cli import run

    code = run(sys.argv[1:], ends=True)
    # The interpreter collects garbage when it ends; the process frees it all the same.
    gc.freeze()
    sys.exit(code)


if __name__ == "__main__":
    main()
