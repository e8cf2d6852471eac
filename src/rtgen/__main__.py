"""The program `rtgen`, also as `python -m rtgen`."""

import sys

from rtgen import __version__


def main() -> None:
    """Run the command line; the version alone needs none of its libraries."""
    if sys.argv[1:] == ["--version"]:
        print("rtgen", __version__)
        return
    from rtgen.cli import run

    sys.exit(run(sys.argv[1:]))


if __name__ == "__main__":
    main()
