"""CANopen components in OpenRTM: NMT commands to a node also affect its component."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from canopen_pair import KINDS

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
STATES = """\
made INACTIVE INACTIVE
started by the proxy ACTIVE ACTIVE
at work ACTIVE ACTIVE
stopped by the proxy INACTIVE INACTIVE
started again ACTIVE ACTIVE
failed ERROR ERROR
reset by the proxy INACTIVE INACTIVE
ended
"""


@pytest.mark.nightly
@pytest.mark.slow
def test_the_states_of_a_drive_and_its_proxy_go_together(
    reference: Path, tmp_path: Path, rtm_environment: dict[str, str]
) -> None:
    behaviours = reference.parent / "reference/refnav"
    shutil.copytree(ROOT / "reference/refnav", behaviours, dirs_exist_ok=True)
    for kind in KINDS:
        script = ["sh", str(reference / "openrtm" / kind / "idlcompile.sh")]
        subprocess.run(script, env=rtm_environment, check=True)
    done = subprocess.run(
        [sys.executable, str(HERE / "canopen_pair.py"), str(reference)],
        cwd=tmp_path,
        env=rtm_environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.stdout == STATES, done.stderr
