"""Saving: the file as it was opened, with the edits of pages, whatever else the run has changed."""

from __future__ import annotations

import os
import random
import re
from collections.abc import Callable, Iterator
from difflib import SequenceMatcher
from pathlib import Path
from shutil import copytree

import pytest
from lxml import etree
from seeds import cases
from ui_bench import GOAL, ROOT, Bench, Page

from rtgen.cli import run as rtgen
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml, rts_profile
from rtgen.compiler.model import System
from rtgen.ui.documents.document import Document, DocumentError
from rtgen.ui.fitting import port_names
from rtgen.ui.protocol import ui

INTERCHANGE = ROOT / "specs/experiments/interchange"
NS = {"rts": "http://www.openrtp.org/namespaces/rts"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of an experiment whose timeline cuts and makes all connections."""
    monkeypatch.chdir(ROOT)
    copytree(INTERCHANGE, tmp_path / "experiment")
    return tmp_path / "experiment"


@pytest.fixture
def bench(folder: Path) -> Iterator[Bench]:
    made = Bench(folder)
    yield made
    made.close()


def read(path: Path) -> System:
    found = rts_profile.load(path)
    assert found.system is not None, found.diagnostics
    assert not found.diagnostics
    return found.system


@pytest.mark.sampled(0)
def test_what_a_timeline_has_connected_is_not_saved(bench: Bench, folder: Path) -> None:
    page = bench.page()
    before = (folder / "system.xml").read_text()
    page.done("time", 20.0)
    page.done("file", "")
    assert (folder / "system.xml").read_text() == before
    page.done("added", ui.AddComponent("JoystickA", "Mine0"))
    page.done("file", "")
    after = (folder / "system.xml").read_text()
    opcodes = SequenceMatcher(
        None, before.splitlines(), after.splitlines(), autojunk=False
    ).get_opcodes()
    assert [kind for kind, *_ in opcodes] == ["equal", "insert", "equal"]
    assert [c.instance for c in read(folder / "system.xml").components][-1] == "Mine0"
    assert rtgen(["run", str(folder), "-q"]) == 0


def test_the_time_that_is_set_has_the_edits_but_not_those_of_the_timeline(
    bench: Bench,
) -> None:
    page, session = bench.page(), bench.session
    names = {each.name for each in session.system.connectors}
    page.done("time", 20.0)
    assert {each.name for each in session.system.connectors} != names
    page.done("connection", session.system.connectors[-1].name)
    page.done("time", 10.0)
    assert {each.name for each in session.system.connectors} == names
    cut = session.system.connectors[0].name
    page.done("connection", cut)
    page.done("time", 12.0)
    assert {each.name for each in session.system.connectors} == names - {cut}


def test_undone_edits_leave_the_file_as_it_was(bench: Bench, folder: Path) -> None:
    page, session = bench.page(), bench.session
    before = (folder / "system.xml").read_bytes()
    assert session.edit_state().saved
    page.done("removed", "JoystickA0")
    page.done("place", ui.Moved("BlackShip0", ui.Location(1.0, 2.0)))
    assert not session.edit_state().saved
    page.done("file", "")
    assert session.edit_state().saved
    assert (folder / "system.xml").read_bytes() != before
    page.done("undone", True)
    assert not session.edit_state().saved
    page.done("redone", True)
    assert session.edit_state().saved
    page.done("undone", True)
    page.done("undone", True)
    page.done("file", "")
    assert (folder / "system.xml").read_bytes() == before


def test_an_edit_of_what_the_timeline_has_made_concerns_the_run_alone(
    bench: Bench,
) -> None:
    page, session = bench.page(), bench.session
    page.done("step", 14.6)
    made = session.system.connectors[-1]
    page.done("connection", made.name)
    assert session.edit_state().saved
    assert session.edit_state().undo == f"cut {made.name}"
    page.done("undone", True)
    assert made.name in [each.name for each in session.system.connectors]


# Files of others.


def moved(page: Page) -> None:
    page.done("place", ui.Moved("BlackShip0", ui.Location(1.0, 2.0)))


def test_another_file_is_replaced_only_when_asked(bench: Bench, folder: Path) -> None:
    page, session = bench.page(), bench.session
    other = folder / "other.xml"
    other.write_bytes(text := GOAL.read_bytes())
    moved(page)
    result = page.ask("file", str(other))
    assert (result.done, result.code) == (False, "UIS0011")
    assert "exists already" in result.message
    assert other.read_bytes() == text
    assert session.file == str(folder)
    assert not session.edit_state().saved
    result = page.done("replaced", str(other))
    assert read(other).name == "interchange"
    assert (folder / "other.xml~").read_bytes() == text
    assert "other.xml~" in result.text
    # it is the session's own file now
    page.done("undone", True)
    assert page.done("file", "").text == ""
    other.write_bytes(text)
    moved(page)
    assert page.ask("file", "").code == "UIS0011"
    page.done("replaced", "")
    assert (folder / "other.xml.~2~").read_bytes() == text


def test_a_file_that_has_changed_on_the_disk_is_not_replaced_unasked(
    bench: Bench, folder: Path
) -> None:
    page, file = bench.page(), folder / "system.xml"
    moved(page)
    text = file.read_text().replace("Experiment 1", "Experiment one")
    file.write_text(text)
    result = page.ask("file", "")
    assert result.code == "UIS0011"
    assert "changed on the disk" in result.message
    assert file.read_text() == text
    file.unlink()
    page.done("file", "")
    assert "Experiment 1" in file.read_text()


def test_a_file_keeps_its_rights_and_links(bench: Bench, folder: Path) -> None:
    page, file = bench.page(), folder / "system.xml"
    target = folder / "real.xml"
    file.rename(target)
    file.symlink_to("real.xml")
    target.chmod(0o640)
    moved(page)
    page.done("file", "")
    assert file.is_symlink()
    assert target.stat().st_mode & 0o777 == 0o640
    assert b'rtsExt:x="1"' in target.read_bytes()
    names = {each.name for each in INTERCHANGE.iterdir()}
    assert {each.name for each in folder.iterdir()} == names | {"real.xml"}


def test_what_is_no_file_is_not_read(bench: Bench, folder: Path) -> None:
    page = bench.page()
    moved(page)
    os.mkfifo(folder / "pipe.xml")
    (folder / "endless.xml").symlink_to("/dev/zero")
    for name in ("pipe.xml", "endless.xml"):
        assert page.ask("file", str(folder / name)).code == "UIS0010", name


def test_a_file_that_could_no_longer_be_run_is_a_question(
    bench: Bench, folder: Path
) -> None:
    page = bench.page()
    page.done("removed", "RefHard0")
    result = page.ask("file", "")
    assert result.code == "UIS0011"
    assert "'RefHard0.truth' is not a pose of the system" in result.message
    page.done("replaced", "")
    saved = read(folder / "system.xml")
    assert "RefHard0" not in dict(saved.properties)["rtgen.run.pose"]


# Forms of files.


def edited(document: Document) -> bytes:
    return document.octets(
        [
            lambda file: file.move("Odometry0", 1, 2),
            lambda file: file.configure("Odometry0", "日本", "名", "値"),
        ]
    )


@pytest.mark.parametrize(
    ("encoding", "declared"),
    [
        ("utf-8", "UTF-8"),
        ("utf-8-sig", "UTF-8"),
        ("utf-16", "UTF-16"),
        ("shift_jis", "Shift_JIS"),
        ("euc_jp", "EUC-JP"),
        ("latin-1", "ISO-8859-1"),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_encodings_and_ends_of_lines_stay(
    encoding: str, declared: str, newline: str
) -> None:
    text = GOAL.read_text().replace('encoding="UTF-8"', f'encoding="{declared}"')
    if encoding != "latin-1":
        text = text.replace("<rts:Components", "<!-- 表 ソ -->\n<rts:Components", 1)
    data = text.replace("\n", newline).encode(encoding)
    document = Document("s.xml", data)
    after = edited(document)
    [odometry] = [
        c for c in document_system(after).components if c.instance == "Odometry0"
    ]
    assert dict(odometry.configuration)["日本"] == (("名", "値"),)
    before_lines = data.decode(encoding).split(newline)
    after_lines = after.decode(encoding).split(newline)
    assert not [line for line in after_lines if "\n" in line or "\r" in line]
    matcher = SequenceMatcher(None, before_lines, after_lines, autojunk=False)
    changed = [each for each in matcher.get_opcodes() if each[0] != "equal"]
    assert sum(end - start for _, start, end, _, _ in changed) == 1
    assert sum(end - start for *_, start, end in changed) == 4


def document_system(data: bytes, file: str = "s.xml") -> System:
    found = rts_profile.load_bytes(data, file)
    assert found.system is not None, found.diagnostics
    return found.system


FLOW = """# A system in one line, and a comment.
rtsProfile: {id: 'RTSystem:a:b:1', components: [{id: 'RTC:a:b:C:1', instanceName: C0}]}
"""


def test_yaml_keeps_its_comments() -> None:
    root = located_xml.parse(GOAL.read_text(), "s.xml")
    lines = profile_yaml.to_yaml(root).splitlines()
    text = "\n".join(f"{line} # {number}" for number, line in enumerate(lines)) + "\n"
    after = edited(Document("s.yaml", text.encode())).decode()
    numbers = re.findall(r"# (\d+)$", after, re.MULTILINE)
    assert len(numbers) == len(lines)
    system = document_system(after.encode(), "s.yaml")
    [odometry] = [c for c in system.components if c.instance == "Odometry0"]
    assert odometry.location is not None
    assert odometry.location[:2] == (1, 2)
    after = Document("s.yaml", FLOW.encode()).octets(
        [lambda file: file.configure("C0", "default", "gain", "1")]
    )
    assert after.decode().startswith("# A system in one line")
    [component] = document_system(after, "s.yaml").components
    assert component.configuration == (("default", (("gain", "1"),)),)


def test_characters_that_no_file_can_hold_are_refused() -> None:
    document = Document("s.xml", GOAL.read_bytes())
    with pytest.raises(DocumentError, match="cannot hold"):
        document.octets([lambda file: file.configure("Odometry0", "a", "b", "\x01")])


# Random edits.


class Editor:
    """Makes random edits on a page, and keeps what the file should have."""

    def __init__(self, bench: Bench, draw: random.Random) -> None:
        self.bench = bench
        self.draw = draw
        self.page = bench.page()
        first = self.parts(bench.session.edits.octets())
        self.states = [first]
        """What the file should have, after each of the edits that can be undone."""
        self.undone: list[set[tuple[str, ...]]] = []

    @staticmethod
    def parts(data: bytes) -> set[tuple[str, ...]]:
        """Return what a file says, read without rtgen."""
        root = etree.fromstring(data)
        found: set[tuple[str, ...]] = set()
        rts, ext = (
            "{http://www.openrtp.org/namespaces/rts}",
            "{http://www.openrtp.org/namespaces/rts_ext}",
        )
        for c in root.findall(f"{rts}Components"):
            name = c.get(f"{rts}instanceName", "")
            found.add(("component", name, c.get(f"{rts}id", "")))
            found.add(("active", name, c.get(f"{rts}activeConfigurationSet", "")))
            for place in c.findall(f"{ext}Location"):
                found.add(
                    ("place", name, place.get(f"{ext}x", ""), place.get(f"{ext}y", ""))
                )
            for values in c.findall(f"{rts}ConfigurationSets"):
                for item in values:
                    given = values.get(f"{rts}id"), item.get(f"{rts}name")
                    text = item.get(f"{rts}data", "")
                    found.add(("value", name, *map(str, given), text))
        for kind in ("Data", "Service"):
            for c in root.findall(f"{rts}{kind}PortConnectors"):
                ends = sorted(
                    str(c.find(f"{rts}{end}{kind}Port").get(f"{rts}portName"))  # type: ignore[union-attr]
                    for end in ("source", "target")
                )
                found.add(("wire", *ends))
        return found

    def edit(self, change: Callable[[set[tuple[str, ...]]], None]) -> None:
        state = set(self.states[-1])
        change(state)
        self.states.append(state)
        self.undone = []

    def step(self) -> None:
        """Make one edit, or let time pass."""
        session, page, draw = self.bench.session, self.page, self.draw
        system = session.system
        instances = [*system.instances]
        match draw.randrange(10):
            case 0:
                page.done("step", draw.uniform(0.1, 6.0))
            case 1 if len(self.states) > 1:
                page.ask("undone", True)
                self.undone.append(self.states.pop())
            case 2 if self.undone:
                page.ask("redone", True)
                self.states.append(self.undone.pop())
            case 3 if system.connectors:
                connector = draw.choice(system.connectors)
                page.done("connection", connector.name)
                ends = tuple(sorted((str(connector.source), str(connector.target))))
                self.edit(lambda s: s.discard(("wire", *ends)))
            case 4:
                self.connect(instances)
            case 5:
                x, y = draw.randrange(900), draw.randrange(900)
                name = draw.choice(instances)
                page.done("place", ui.Moved(name, ui.Location(x, y)))
                self.edit(lambda s: self.put(s, "place", (name,), (str(x), str(y))))
            case 6:
                self.configure(draw.choice(instances))
            case 7 if len(instances) > 5:
                name = draw.choice(instances)
                page.done("removed", name)
                self.edit(lambda s: self.remove(s, name))
            case 8:
                self.add(
                    draw.choice(["JoystickA", "RefHardControl", "OmniWheelControl"])
                )
            case 9:
                page.done("time", draw.uniform(0.0, 40.0))
                self.states, self.undone = [self.states[-1]], []

    @staticmethod
    def put(
        state: set[tuple[str, ...]],
        kind: str,
        subject: tuple[str, ...],
        value: tuple[str, ...],
    ) -> None:
        known = (kind, *subject)
        state -= {each for each in state if each[: len(known)] == known}
        state.add((*known, *value))

    @staticmethod
    def remove(state: set[tuple[str, ...]], name: str) -> None:
        state -= {each for each in state if each[0] != "wire" and each[1] == name}
        wires = {each for each in state if each[0] == "wire"}
        state -= {w for w in wires if any(e.startswith(f"{name}.") for e in w[1:])}

    def connect(self, instances: list[str]) -> None:
        first, second = (self.draw.choice(instances) for _ in range(2))
        ports = [
            (i, p)
            for i in (first, second)
            for p in port_names(self.bench.session.system, i)
        ]
        source, target = self.draw.choice(ports), self.draw.choice(ports)
        result = self.page.ask(
            "wire",
            ui.Connect(ui.PortAddress(*source), ui.PortAddress(*target)),
        )
        if result.done:
            ends = sorted(map(".".join, (source, target)))
            self.edit(lambda s: s.add(("wire", *ends)))

    def configure(self, name: str) -> None:
        sets = self.bench.session.system.component(name).configuration_sets
        texts = sets.texts(sets.active)
        if not texts:
            return
        parameter, text = self.draw.choice([*texts.items()])
        set_id = self.draw.choice(["default", "mine"])
        wanted = ui.SetParameter(name, set_id, parameter, text)
        self.page.done("setting", wanted)
        self.edit(lambda s: self.put(s, "value", (name, set_id, parameter), (text,)))
        if set_id == "mine" and self.draw.random() < 0.5:
            self.page.done("chosen", ui.ActiveSet(name, "mine"))
            self.edit(lambda s: self.put(s, "active", (name,), ("mine",)))

    def add(self, type_: str) -> None:
        x, y = self.draw.randrange(900), self.draw.randrange(900)
        wanted = ui.AddComponent(type_, "", True, ui.Location(x, y))
        before = {*self.bench.session.system.instances}
        self.page.done("added", wanted)
        [name] = {*self.bench.session.system.instances} - before

        def change(state: set[tuple[str, ...]]) -> None:
            profile = self.bench.session.system.component(name).profile
            parts = profile.vendor, profile.category, type_, profile.version
            state |= {
                ("component", name, f"RTC:{':'.join(parts)}"),
                ("active", name, "default"),
                ("place", name, str(x), str(y)),
            }

        self.edit(change)


END = b"</rts:RtsProfile>"
BLOCK = re.compile(
    r"  <rts:(?:Components|DataPortConnectors) .*?"
    r"</rts:(?:Components|DataPortConnectors)>\n",
    re.DOTALL,
)


@pytest.mark.sampled(0)
@pytest.mark.random
@pytest.mark.parametrize("number", cases(3))
def test_random_edits_during_a_run_with_a_timeline(
    bench: Bench, folder: Path, number: int
) -> None:
    file, timeline = folder / "system.xml", folder / "timeline.toml"
    # Edits change what is measured.
    timeline.write_text(timeline.read_text().partition("[[measure]]")[0])
    before = file.read_text()
    editor = Editor(bench, random.Random(number))
    first = editor.states[0]
    for _ in range(12):
        editor.step()
        assert not bench.session.runner.over
    editor.page.done("replaced", "")
    after = file.read_text()
    assert editor.parts(after.encode()) == editor.states[-1]
    # What is not edited is there as it was, in its order.
    position = after.index(before[: before.index("  <rts:Components")])
    for block in BLOCK.findall(before):
        facts = editor.parts(
            before.partition("\n\n")[0].encode() + block.encode() + END
        )
        subjects = {fact[:2] if fact[0] != "wire" else fact for fact in facts}
        known, now = (
            {fact for fact in state if fact[:2] in subjects or fact in subjects}
            for state in (first, editor.states[-1])
        )
        if known == now:
            position = after.index(block, position) + len(block)
    assert len(re.findall("<!--", after)) == len(re.findall("<!--", before))
    assert rtgen(["run", str(folder), "--until", "60", "-q"]) == 0
