"""Response times of the language server after an edit of a file of 5,000 lines; its memory.

    python benchmarks/lsp.py

The server runs as an editor starts it, over pipes. Each request follows immediately on an edit, so
the server answers while it waits for the next edit, or analyses. Wall time from the request to the
answer as parsed JSON, and from the last edit of five to its findings. Memory is the resident set
after the findings of each edit, of the reference tree and of a file of 12,800 lines.
"""

from __future__ import annotations

import json
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tables import Arguments, Results, Table

LINES = 5000
ROUNDS = 25
LIMIT = 0.1
"""Maximum median of each request [s]."""
LONG = 12_800
EDITS = 10
MEMORY = 100
"""Maximum resident set with the reference tree [MB]."""
ROOT = Path(__file__).resolve().parent.parent
_MEMBER = re.compile(r"long count;|double x;")


def definitions(lines: int) -> str:
    """Return IDL with structs of structs, enums, sequences; each tenth is an interface."""
    out = ["module Large {"]
    number = 0
    while len(out) < lines - 12:
        before = f"S{number - 1}" if number % 20 else "short"
        out += [
            f"  /// The struct number {number}.",
            f"  struct S{number} {{",
            "    long count;",
            '    @unit("m") double distance;  ///< To the wall.',
            "    sequence<long, 8> numbers;",
            f"    {before} inner;",
            "  };",
            f"  enum E{number} {{ FIRST{number}, LAST{number} }};",
            f"  typedef sequence<S{number}> List{number};",
            "",
        ]
        if number % 10 == 9:
            out += [
                f"  interface I{number} {{",
                f"    S{number} get(in E{number} which, in List{number} all);",
                "  };",
            ]
        number += 1
    out += ["  // The end."] * (lines - 1 - len(out)) + ["};"]
    return "\n".join(out) + "\n"


class Client:
    """A server process, and messages to and from it."""

    def __init__(self, folder: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "rtgen", "lsp"],
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self._number = 0
        self.published: dict[str, Any] = {}

    def notify(self, method: str, parameters: Mapping[str, Any]) -> None:
        """Send a notification."""
        self._send({"method": method, "params": parameters})

    def ask(self, method: str, parameters: Mapping[str, Any] | None = None) -> Any:
        """Send a request and wait for its answer."""
        self._number += 1
        message = {"id": self._number, "method": method}
        self._send(message | ({} if parameters is None else {"params": parameters}))
        while True:
            answer = self._received()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def findings(self, version: int) -> None:
        """Wait for the findings of a version."""
        while self.published.get("version") != version:
            self._received()

    @property
    def memory(self) -> float:
        """The resident set of the server [MB]."""
        status = Path(f"/proc/{self._process.pid}/status").read_text(encoding="ascii")
        return int(status.partition("VmRSS:")[2].split()[0]) / 1024

    def close(self) -> None:
        """End the server."""
        self.ask("shutdown")
        self.notify("exit", {})
        self._process.wait(timeout=60)

    def _send(self, message: Mapping[str, Any]) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self._process.stdin.flush()

    def _received(self) -> Any:
        stream = self._process.stdout
        assert stream is not None
        length = 0
        while (line := stream.readline().strip()) or not length:
            if line.lower().startswith(b"content-length:"):
                length = int(line.partition(b":")[2])
        message = json.loads(stream.read(length))
        if message.get("method") == "textDocument/publishDiagnostics":
            self.published = message["params"]
        return message


class Session:
    """A file that is open in the server, and edits of it."""

    def __init__(self, client: Client, path: Path, text: str) -> None:
        self._client = client
        self.document = {"uri": path.as_uri()}
        self.lines = text.split("\n")
        self.version = 1
        self._draw = random.Random(1)
        item = self.document | {"languageId": "idl", "version": 1, "text": text}
        client.notify("textDocument/didOpen", {"textDocument": item})

    def edit(self) -> int:
        """Add a comment or a member to a struct; return the line of the struct's name."""
        numbers = [i for i, line in enumerate(self.lines) if _MEMBER.search(line)]
        line = self._draw.choice(numbers)
        self.version += 1
        kind = self._draw.randrange(2)
        new = " // x" if kind else f"\n    long more{self.version};"
        place = {"line": line, "character": len(self.lines[line])}
        change = {"range": {"start": place, "end": place}, "text": new}
        self._client.notify(
            "textDocument/didChange",
            {
                "textDocument": self.document | {"version": self.version},
                "contentChanges": [change],
            },
        )
        self.lines[line : line + 1] = (self.lines[line] + new).split("\n")
        return line - 1

    def requests(self, line: int) -> dict[str, tuple[str, dict[str, Any]]]:
        """Return the requests of an editor about the name of a struct."""
        document = {"textDocument": self.document}
        there = document | {"position": {"line": line, "character": 10}}
        inside = document | {"position": {"line": line + 1, "character": 4}}
        start = {"line": line, "character": 0}
        end = {"line": line + 60, "character": 0}
        screen = document | {"range": {"start": start, "end": end}}
        return {
            "hover": ("textDocument/hover", there),
            "definition": ("textDocument/definition", there),
            "references": (
                "textDocument/references",
                there | {"context": {"includeDeclaration": True}},
            ),
            "highlights": ("textDocument/documentHighlight", there),
            "completion": ("textDocument/completion", inside),
            "rename": ("textDocument/rename", there | {"newName": "Other"}),
            "document symbols": ("textDocument/documentSymbol", document),
            "workspace symbols": ("workspace/symbol", {"query": "s12"}),
            "semantic tokens": ("textDocument/semanticTokens/full", document),
            "semantic tokens, a screen": ("textDocument/semanticTokens/range", screen),
            "folding": ("textDocument/foldingRange", document),
            "inlay hints, a screen": ("textDocument/inlayHint", screen),
            "code actions": (
                "textDocument/codeAction",
                screen | {"context": {"diagnostics": []}},
            ),
        }


def started(folder: Path, path: Path) -> tuple[Client, Session]:
    """Start a server for a folder, and open a file; return after the findings."""
    client = Client(folder)
    client.ask(
        "initialize",
        {"processId": None, "rootUri": folder.as_uri(), "capabilities": {}},
    )
    client.notify("initialized", {})
    session = Session(client, path, path.read_text(encoding="utf-8"))
    client.findings(session.version)
    return client, session


def memory(folder: Path, edits: int, table: Table) -> None:
    """Measure the memory of servers: opened, and after edits."""
    path = folder / "long.idl"
    path.write_text(definitions(LONG), encoding="utf-8")
    reference = ROOT / "specs" / "idl" / "intellirobot.idl"
    for name, root, file, limit in (
        ("reference tree", ROOT, reference, f"opened at most {MEMORY}"),
        (f"{LONG:,} lines", folder, path, ""),
    ):
        client, session = started(root, file)
        sizes = [client.memory]
        for _ in range(edits):
            session.edit()
            client.findings(session.version)
            sizes.append(client.memory)
        table.add(name, sizes[0], sizes[len(sizes) // 2], sizes[-1], limit)
        client.close()


def measured(folder: Path, rounds: int, table: Table) -> bool:
    """Measure all requests, also the findings; return whether all are within the limit."""
    path = folder / "large.idl"
    path.write_text(definitions(LINES), encoding="utf-8")
    client, session = started(folder, path)
    medians, analyses = [], []

    def show(name: str, seconds: list[float]) -> None:
        median = statistics.median(seconds)
        table.add(name, 1000 * median, 1000 * max(seconds))

    for name in session.requests(0):
        seconds = []
        for number in range(rounds):
            method, parameters = session.requests(session.edit())[name]
            begun = time.perf_counter()
            client.ask(method, parameters)
            seconds.append(time.perf_counter() - begun)
            if number % 5 == 4 or number + 1 == rounds:
                client.findings(session.version)
                analyses.append(time.perf_counter() - begun)
        show(name, seconds)
        medians.append(statistics.median(seconds))
    show("findings of the edit", analyses)
    client.close()
    return max(medians) <= LIMIT


def main() -> None:
    """Return 1 if a median is above the limit."""
    chosen = Arguments(__doc__, rounds=ROUNDS).parse_args()
    with Results(__file__, chosen) as results, tempfile.TemporaryDirectory() as folder:
        columns = ("median [ms]", ".1f"), ("most [ms]", ".1f")
        table = results.table("requests", f"{LINES:,} lines of IDL", *columns)
        fine = measured(Path(folder), chosen.rounds, table)
        columns = ("opened", ".0f"), ("after half", ".0f"), (f"{EDITS} edits", ".0f")
        edits = 1 if chosen.smallest else EDITS
        memory(Path(folder), edits, results.table("memory", "MB", *columns, "limit"))
    print(f"each median at most {1000 * LIMIT:.0f} ms: {'yes' if fine else 'no'}")
    sys.exit(not fine and not chosen.smallest)


if __name__ == "__main__":
    main()
