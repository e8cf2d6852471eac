"""Runs omniidl over many files: a fork for each, so that none can affect the next.

Standard input: a JSON list of {folder, file, arguments}; standard output: a list of {status, facts,
messages}, where a negative status is the number of a signal.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

import jeteve_omniorb
import rtgen_facts  # noqa: F401  # loaded before the forks
from omniidl import main


def run(folder, file, arguments):
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as messages:
        child = os.fork()
        if child == 0:
            status = 70
            try:
                os.chdir(folder)
                os.dup2(out.fileno(), 1)
                os.dup2(messages.fileno(), 2)
                main.main(["omniidl", *arguments, "-b", "rtgen_facts", file])
                status = 0
            except SystemExit as end:
                status = int(end.code or 0)
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        out.seek(0)
        messages.seek(0)
        return {
            "status": status,
            "facts": json.loads(out.read()) if status == 0 else None,
            "messages": messages.read().decode("utf-8", "replace"),
        }


if __name__ == "__main__":
    programs = Path(jeteve_omniorb.__file__).parent / "bin"
    os.environ["PATH"] = f"{programs}{os.pathsep}{os.environ['PATH']}"
    requests = json.load(sys.stdin)
    print(json.dumps([run(**request) for request in requests]))
