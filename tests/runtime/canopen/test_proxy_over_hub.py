"""A proxy in real time over a hub that is killed and restarted."""

from __future__ import annotations

from hub_process import HubProcess
from proxy_bench import DriveProxy, SimpleNode

from rtgen.runtime import SECOND, LifeCycleState, RealClock, System


def until(system: System, state: str) -> bool:
    wanted = LifeCycleState[f"{state}_STATE"]
    limit = system.time + 5 * SECOND
    return system.run(limit, until=lambda s: s.state("Drive0") is wanted)


def test_the_hub_dies_and_comes_back() -> None:
    with HubProcess() as hub, System(RealClock()) as system:
        # Two links, so that every frame goes through the hub.
        node = SimpleNode(hub.link())
        proxy = DriveProxy("Drive0")
        proxy.configuration_sets.set("interface", "socketcand")
        proxy.configuration_sets.set("options", hub.options())
        system.add(proxy, 100.0)
        node.boot()
        system.activate("Drive0")
        assert until(system, "ACTIVE"), proxy.reason
        hub.end()
        assert until(system, "ERROR")
        assert proxy.reason == "node 5 cannot be reached: the bus is gone"
        system.reset("Drive0")
        system.run(system.time + SECOND // 10)
        assert system.state("Drive0").name == "ERROR_STATE"
        with HubProcess(port=hub.port):
            assert node.link.wait(lambda: node.link.up, 20 * SECOND)
            for _ in range(10):
                system.reset("Drive0")
                if until(system, "INACTIVE"):
                    break
            system.activate("Drive0")
            assert until(system, "ACTIVE"), proxy.reason
        node.leave()
