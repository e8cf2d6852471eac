"""The program `rtgen`, also as `python -m rtgen`."""

import gc
import io
import os
import sys

try:
    from rtgen.facts.version import __version__
except ModuleNotFoundError as error:
    if not str(error.name).startswith("rtgen"):
        raise
    sys.exit(
        "error: rtgen needs rtgen-runtime of its own version, which is not installed\n"
        "  hint: pip install ./runtime in a clone of rtgen"
    )


def main() -> None:
    """Run the command line. `rtgen --version`, stored answers and pages import nothing else."""
    _open_streams()
    arguments = sys.argv[1:]
    if arguments == ["--version"]:
        print("rtgen", __version__)
        return
    from rtgen.tools.kit.answers import repeat

    for stream in (sys.stdout, sys.stderr):
        # Terminals of older encodings, such as cp932, lack characters of messages.
        if isinstance(stream, io.TextIOWrapper) and stream.encoding.lower() != "utf-8":
            from rtgen.facts.substitutes import registered

            stream.reconfigure(errors=registered())
    code = repeat(arguments)
    if code is None and arguments[:1] == ["explain"]:
        from rtgen.tools.kit.pages import explained

        code = explained(arguments)
    if code is None:
        from rtgen.cli import run

        code = run(arguments, ends=True)
    # A collection at interpreter exit would only cost time: the process frees its memory anyway.
    gc.freeze()
    sys.exit(code)


def _open_streams() -> None:
    """Open the null device for streams that the caller has closed: files would take their place."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            null = os.open(os.devnull, os.O_RDWR)
            setattr(sys, name, os.fdopen(null, mode, encoding="utf-8"))


if __name__ == "__main__":
    main()
