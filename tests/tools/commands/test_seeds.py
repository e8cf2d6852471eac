"""The seed of the random tests: one for each commit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import seeds


def _seed_after(folder: Path, subject: str) -> int:
    git = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b"]
    command = [*git, "commit", "--quiet", "--allow-empty", "-m", subject]
    subprocess.run(command, check=True)
    return seeds.seed_of(seeds.commit(folder))


def test_each_commit_has_a_seed_of_its_own_and_keeps_it(tmp_path: Path) -> None:
    subprocess.run(["git", "init", "--quiet", str(tmp_path)], check=True)
    assert seeds.commit(tmp_path) is None, "a repository without a commit"
    drawn = [_seed_after(tmp_path, subject) for subject in "abc"]
    assert len({*drawn}) == 3
    assert seeds.seed_of(seeds.commit(tmp_path)) == drawn[-1]


@pytest.mark.parametrize(
    ("commit", "seed"),
    [("0f0f0f1" + "3" * 33, 0x0F0F0F1), (None, seeds.SEED)],
)
def test_the_seed_is_the_abbreviated_commit(commit: str | None, seed: int) -> None:
    assert seeds.seed_of(commit) == seed


def test_a_given_seed_repeats_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTGEN_SEED", "77")
    assert seeds.seed.__wrapped__() == 77


@pytest.mark.nightly
def test_what_is_left_of_a_sampled_test_is_nightly() -> None:
    path = "tests/compiler/cdl/test_limits.py"
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", path, "-m"]
    counts = []
    for markers in ("sampled and not nightly", "sampled and nightly", "sampled"):
        done = subprocess.run(
            [*command, markers], cwd=seeds.ROOT, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stdout
        counts.append(done.stdout.count("::test_endless["))
    few, others, both = counts
    assert (few, few + others) == (4, both)
