"""The installations of ROS 2 that other tests use."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros2_peers import DISTRIBUTIONS, installation

pytestmark = [pytest.mark.peer, pytest.mark.waits]

NODE = """
import rclpy, sys
rclpy.init()
node = rclpy.create_node(sys.argv[1])
print(node.get_fully_qualified_name(), rclpy.get_rmw_implementation_identifier())
"""


@pytest.mark.sampled(1)
@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_a_node_uses_fast_dds(distribution: str, tmp_path: Path) -> None:
    script = tmp_path / "node.py"
    script.write_text(NODE)
    found = installation(distribution).output(script, "probe")
    assert found.split() == ["/probe", "rmw_fastrtps_cpp"]
