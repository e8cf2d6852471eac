"""A drive and its proxy as OpenRTM components of one process; prints their states.

`python canopen_pair.py OUT`, OUT being the output folder of the reference build.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

KINDS = ("EposDriveDevice", "EposDriveProxy")


def main() -> None:
    out = Path(sys.argv[1])
    rtm: Any = import_module("OpenRTM_aist")
    options = ("logger.enable:NO", "manager.shutdown_on_nortcs:NO", "naming.enable:NO")
    given = [text for each in options for text in ("-o", each)]
    manager = rtm.Manager.init(["pair", *given, "-o", "exec_cxt.periodic.rate:100"])
    manager.activateManager()
    manager.runManager(True)
    for kind in KINDS:
        sys.path.append(str(out / "openrtm" / kind))
        getattr(import_module(kind), f"{kind}Init")(manager)
    device = manager.createComponent("EposDriveDevice?conf.default.node_id=1")
    proxy = manager.createComponent(
        "EposDriveProxy?conf.default.node_id=1&conf.default.master=1"
    )
    references = [each.getObjRef() for each in (device, proxy)]

    def states() -> tuple[str, ...]:
        return tuple(str(rtm.get_state(each)[1])[:-6] for each in references)

    def until(condition: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + 20.0
        while not condition():
            if time.monotonic() > end:
                print(
                    f"no {what}: {states()} {device._host.behaviour.reason}", flush=True
                )
                sys.exit(1)
            time.sleep(0.01)
        print(what, *states(), flush=True)

    until(lambda: states() == ("INACTIVE", "INACTIVE"), "made")
    rtm.activate(references[1])
    until(lambda: states() == ("ACTIVE", "ACTIVE"), "started by the proxy")
    until(lambda: proxy._host.behaviour.is_active, "at work")
    rtm.deactivate(references[1])
    until(lambda: states() == ("INACTIVE", "INACTIVE"), "stopped by the proxy")
    rtm.activate(references[1])
    until(lambda: states() == ("ACTIVE", "ACTIVE"), "started again")
    device._host.behaviour._request_failure("smoke")
    until(lambda: states() == ("ERROR", "ERROR"), "failed")
    rtm.reset(references[1])
    until(lambda: states() == ("INACTIVE", "INACTIVE"), "reset by the proxy")
    for each in (proxy, device):
        each.exit()
    print("ended", flush=True)
    manager.shutdown()


if __name__ == "__main__":
    main()
