#!/usr/bin/env python3
"""Run a drive of the profile (examples/ppo_drive.gsd, examples/ppo_drive.toml) with pyprofibus 1.13, PPO 1.

Exit status 0 if all went well, 1 with one line `FAIL step: expected ..., got ...` otherwise.
"""

import argparse
import io
import struct
import sys
import time

from pyprofibus.conf import PbConf

CONFIGURATION = """
[PROFIBUS]
debug=0
[PHY]
type=serial
dev={port}
baud=500000
[DP]
master_class=1
master_addr=2
[SLAVE_0]
name=drive
addr=7
gsd={gsd}
module_0=PPO 1: PKW, 2 words PZD
sync_mode=0
freeze_mode=0
group_mask=1
watchdog_ms=2000
input_size=12
output_size=12
"""

LIMIT = 20.0  # seconds for each step
OFF1, RUN = 0x047E, 0x047F

# PKE, IND, PWE, STW, setpoint; and what must come: AK with its value or None, ZSW under a mask, actual value or None.
STEPS = [
    ("start-up", (0, 0, 0, 0x0400, 0), None, (0x0040, 0x004F), None),
    ("OFF1", (0, 0, 0, OFF1, 0), None, (0x0001, 0x004F), None),
    ("ramp-up time", (0x1002, 0, 0, OFF1, 0), (1, 20), (0x0001, 0x004F), None),
    ("a ramp-up time of 0.5 s", (0x2002, 0, 5, OFF1, 0), (1, 5), (0x0001, 0x004F), None),
    ("a ramp-up time beyond its limit", (0x2002, 0, 6501, OFF1, 0), (7, 2), (0x0001, 0x004F), None),
    ("run with 50 %", (0, 0, 0, RUN, 0x2000), None, (0x0007, 0x004F), 0x2000),
    ("actual speed", (0x100A, 0, 0, RUN, 0x2000), (1, 750), (0x0007, 0x004F), 0x2000),
    ("third fixed speed", (0x601E, 0x0300, 0, RUN, 0x2000), (5, 70000), (0x0007, 0x004F), None),
    ("description of the fixed speeds", (0x401E, 0x0100, 0, RUN, 0x2000), (3, 0x4104), (0x0007, 0x004F), None),
    ("a fault", (0x2014, 0, 77, RUN, 0x2000), (1, 77), (0x0008, 0x004F), None),
    ("its number", (0x63B3, 0x0100, 0, RUN, 0), (4, 77), (0x0008, 0x004F), None),
    ("acknowledged", (0, 0, 0, RUN | 0x0080, 0), None, (0x0040, 0x004F), None),
    ("OFF1 again", (0, 0, 0, OFF1, 0), None, (0x0001, 0x004F), None),
]


def play(master, slave, words, reply, zsw, actual):
    """The last inputs if what must come has not come in time, None if it has."""
    end = time.monotonic() + LIMIT
    last = "nothing"
    while time.monotonic() < end:
        slave.setMasterOutData(struct.pack(">HHLHH", *words))
        master.run()
        inputs = slave.getMasterInData()
        if inputs is None:
            time.sleep(0.0003)
            continue
        pke, _, value, status, hiw = struct.unpack(">HHLHH", bytes(inputs))
        last = f"AK {pke >> 12} PNU {pke & 0x7FF} value {value} ZSW {status:04X} actual {hiw:04X}"
        answered = reply is None or (pke & 0x7FF, (pke >> 12, value)) == (words[0] & 0x7FF, reply)
        if answered and status & zsw[1] == zsw[0] and (actual is None or hiw == actual):
            return None
    return last


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", required=True)
    parser.add_argument("--gsd", required=True)
    args = parser.parse_args()
    conf = PbConf(io.StringIO(CONFIGURATION.format(port=args.port, gsd=args.gsd)))
    master = conf.makeDPM()
    slave = conf.slaveConfs[0].makeDpSlaveDesc()
    master.addSlave(slave)
    master.initialize()
    try:
        for step, words, reply, zsw, actual in STEPS:
            got = play(master, slave, words, reply, zsw, actual)
            if got is not None:
                print(f"FAIL {step}: expected reply {reply}, ZSW {zsw[0]:04X}, actual {actual}, got {got}")
                return 1
            print(f"{step}: as expected")
    finally:
        master.destroy()
    return 0


if __name__ == "__main__":
    sys.exit(main())
