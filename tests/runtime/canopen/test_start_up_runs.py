"""The start-up of networks is accepted by nodes that enforce CiA 301, and nothing is on 000h.

The networks are random, and those of each description at hand, with values that are changed.
"""

from __future__ import annotations

from pathlib import Path
from random import Random
from shutil import copyfile

import pytest
from random_buses import RandomBus
from seeds import cases
from start_up_runs import problems, problems_of_devices, read, refusals

from rtgen.compiler.frontends.eds import load

ROOT = Path(__file__).parents[3]
GOLDEN = ROOT.parent / "shared" / "golden" / "eds"
FILES = [
    *sorted((ROOT / "specs").rglob("*.eds")),
    *sorted((ROOT / "tests").rglob("golden/cases/*/input/**/*.eds")),
    *sorted((ROOT / "tests").rglob("interop/**/*.eds")),
    *sorted(p for p in GOLDEN.glob("*") if p.suffix.lower() in (".eds", ".dcf")),
]
COUNT = 100


@pytest.mark.nightly
@pytest.mark.random
def test_random_networks_start(tmp_path: Path) -> None:
    accepted, seeds = 0, cases(COUNT, always=COUNT)
    for seed in seeds:
        folder = tmp_path / str(seed)
        folder.mkdir()
        bus, findings = read(RandomBus(seed, folder).file)
        if bus is None:
            continue
        accepted += 1
        found = [*problems(bus, findings), *refusals(bus, findings)]
        if seed % 3 == 0:
            found += problems_of_devices(bus, findings)
        assert not found, f"case {seed}: {found}\n{(folder / 'bus.toml').read_text()}"
    assert accepted > len(seeds) * 3 // 4


CONFIGURED = """
[FileInfo]
FileName=d.dcf
EDSVersion=4.0
[DeviceInfo]
VendorNumber=1
BaudRate_500=1
[DummyUsage]
[1000]
ParameterName=Type
ObjectType=7
DataType=7
AccessType=ro
DefaultValue=0
[1001]
ParameterName=Error
ObjectType=7
DataType=5
AccessType=ro
[1014]
ParameterName=EMCY
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=$NODEID+0x80
ParameterValue=0x555
[1016]
ParameterName=Consumers
ObjectType=8
SubNumber=3
[1016sub0]
ParameterName=Entries
ObjectType=7
DataType=5
AccessType=const
DefaultValue=2
[1016sub1]
ParameterName=First
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=0
ParameterValue=0x050200
[1016sub2]
ParameterName=Second
ObjectType=7
DataType=7
AccessType=rw
DefaultValue=0
ParameterValue=0x070200
"""


def test_a_node_begins_with_its_defaults_or_with_what_its_file_configures(
    tmp_path: Path,
) -> None:
    (tmp_path / "d.dcf").write_text(CONFIGURED)
    (tmp_path / "bus.toml").write_text(
        '[bus]\nbit_rate = 500\n[device.d]\neds = "d.dcf"\n[node.n]\ndevice = "d"\n'
        'id = 9\n[node.n.values]\n"1014" = "$NODEID+0x80"\n'
        '"1016:1" = 0x070300\n"1016:2" = 0x050300\n'
    )
    bus, findings = read(tmp_path / "bus.toml")
    assert bus is not None
    assert not [*problems(bus, findings), *refusals(bus, findings)]


def changed(path: Path) -> list[str]:
    """Return values of a description's communication objects that differ from its defaults."""
    [device] = load([path], root=path.parent, node_id=5).model.devices
    chance, values = Random(0), dict[str, object]()
    choices = {
        0x1006: [10000], 0x1007: [5000], 0x1012: [0x6D0], 0x1014: [0x6D1], 0x1015: [100],
        0x1016: [0x7F0384], 0x1017: [100],
    }  # fmt: skip
    for variable in device.variables:
        index, sub = variable.index, variable.subindex
        if not variable.access.writable or (index == 0x1016 and sub != 1):
            continue
        if index in choices and (index == 0x1016) == bool(sub):
            values[f"{index:04X}:{sub}"] = choices[index][0]
    for pdo in device.pdos:
        kind = device.find(pdo.communication, 2)
        if kind is not None and kind.access.writable and chance.random() < 0.5:
            values[f"{pdo.communication:04X}:2"] = 1
    return [f'"{number}" = {value}' for number, value in values.items()]


@pytest.mark.sampled(5)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
@pytest.mark.parametrize("values", ["defaults", "changes"])
def test_networks_of_each_description_start(
    path: Path, values: str, tmp_path: Path
) -> None:
    if not load([path], root=path.parent).model.devices:
        pytest.skip("a file with errors gives no device")
    copy = tmp_path / f"device{path.suffix.lower()}"
    copyfile(path, copy)
    lines = [
        *("[bus]", "bit_rate = 500", "sync = 0.02", "heartbeat = 0.2"),
        *("[device.d]", f'eds = "{copy.name}"', "[node.n]", 'device = "d"', "id = 5"),
    ]
    if values == "changes":
        lines += ["[node.n.values]", *changed(copy)]
    (tmp_path / "bus.toml").write_text("\n".join(lines))
    bus, findings = read(tmp_path / "bus.toml")
    if bus is None:
        errors = [d for d in findings if d.severity.value == "error"]
        pytest.skip(f"{errors[0].code}: {errors[0].message}")
    found = [*problems(bus, findings), *problems_of_devices(bus, findings)]
    assert not found
