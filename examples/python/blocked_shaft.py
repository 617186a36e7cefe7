#!/usr/bin/env python3
"""A conformance test of a DP master: what does it do when the shaft is blocked in the middle of a travel?

    pip install -r tests/interop/requirements.txt
    python3 examples/python/blocked_shaft.py target/release/profidrive
"""

import json
import subprocess
import sys
from urllib.request import Request, urlopen

from drive import Drive

ENABLE, START, ACKNOWLEDGE = 0x003B, 0x0040, 0x0080  # STW
FAULT, TURN_ON_DISABLED, TARGET_REACHED, READY_TO_TRAVEL = 0x0008, 0x0040, 0x0400, 0x8000  # ZSW


def block(http, blocked):
    body = json.dumps({"blocked": blocked}).encode()
    request = Request(http + "/inputs", body, {"Content-Type": "application/json"}, method="PATCH")
    urlopen(request, timeout=20).close()


def test(drive, http):
    drive.stw = ENABLE
    drive.until("ready to travel", lambda: drive.zsw & READY_TO_TRAVEL)
    drive.stw, drive.target = ENABLE | START, 4000
    drive.until("on its way", lambda: drive.position > 1000)

    block(http, True)
    drive.until("blocked: a fault (ZSW.3)", lambda: drive.zsw & FAULT)
    assert drive.read(1020) & 0x0100, "the system status word shows the fault (SSW.8)"
    assert drive.read(945, job=6) == ord("B"), "the fault buffer says B: the shaft does not turn"
    assert json.load(urlopen(http, timeout=20))["fault"]["fault"] == "B", "the emulator says so too"

    block(http, False)
    drive.stw |= ACKNOWLEDGE
    drive.until("acknowledged: turn-on disabled (ZSW.6)", lambda: drive.zsw & TURN_ON_DISABLED)
    drive.stw = 0
    drive.until("OFF1", lambda: not drive.zsw & TURN_ON_DISABLED)
    drive.stw = ENABLE
    drive.until("ready to travel again", lambda: drive.zsw & READY_TO_TRAVEL)
    drive.stw = ENABLE | START
    drive.until("arrived (ZSW.10)", lambda: drive.zsw & TARGET_REACHED and drive.position == 4000)


command = [sys.argv[1], "emulate", "--panel", "127.0.0.1:0", *sys.argv[2:]]
with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as emulator:
    try:
        # ready link=/dev/pts/3 drives=5 panel=http://127.0.0.1:40123
        ready = dict(word.split("=", 1) for word in emulator.stdout.readline().split()[1:])
        test(Drive(ready["link"]), ready["panel"] + "/api/v1/stations/5")
        print("OK")
    finally:
        emulator.terminate()
