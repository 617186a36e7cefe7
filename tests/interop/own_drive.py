#!/usr/bin/env python3
"""Read and write parameters of examples/own_drive.rs with pyprofibus 1.13 as DP class-1 master.

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
baud={baud}
[DP]
master_class=1
master_addr=2
[SLAVE_0]
name=own
addr=5
gsd={gsd}
sync_mode=0
freeze_mode=0
group_mask=1
watchdog_ms=1000
input_size=12
output_size=12
"""

LIMIT = 15.0  # seconds for the start-up and for each reply

# What is asked: job, parameter, sub-index (high octet of IND), value; and what the reply must be: AK, value.
STEPS = [
    ("ramp time as delivered", (1, 100, 0, 0), (1, 10)),
    ("write the ramp time", (2, 100, 0, 30), (1, 30)),
    ("ramp time as written", (1, 100, 0, 0), (1, 30)),
    ("a ramp time beyond the limits", (2, 100, 0, 61), (7, 2)),
    ("how many speeds", (9, 200, 0, 0), (6, 3)),
    ("write the third speed", (8, 200, 2, 70000), (5, 70000)),
    ("the third speed as written", (6, 200, 2, 0), (5, 70000)),
    ("a fourth speed", (6, 200, 3, 0), (7, 3)),
    ("a parameter of an AG03", (1, 1004, 0, 0), (7, 0)),
]


def reply(master, slave, words):
    """The four words of the reply to a job, once they are about its parameter."""
    end = time.monotonic() + LIMIT
    seen = 0
    while time.monotonic() < end:
        slave.setMasterOutData(struct.pack(">HHLHH", *words, 0x047F, 0x1234))
        master.run()
        inputs = slave.getMasterInData()
        if inputs is None:
            time.sleep(0.0003)
            continue
        pke, ind, value, zsw, actual = struct.unpack(">HHLHH", bytes(inputs))
        # The first inputs may be older than the outputs.
        seen += 1
        if seen > 3 and (pke & 0x07FF, zsw, actual) == (words[0] & 0x07FF, 0x047F, 0x1234):
            return pke >> 12, value
    return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", required=True)
    parser.add_argument("--baud", default="500000")
    parser.add_argument("--gsd", required=True)
    args = parser.parse_args()
    conf = PbConf(io.StringIO(CONFIGURATION.format(port=args.port, baud=args.baud, gsd=args.gsd)))
    master = conf.makeDPM()
    slave = conf.slaveConfs[0].makeDpSlaveDesc()
    master.addSlave(slave)
    master.initialize()
    try:
        for step, (job, number, element, value), expected in STEPS:
            # Job 0 between two jobs, so that each is a new one.
            reply(master, slave, (0, 0, 0))
            got = reply(master, slave, (job << 12 | number, element << 8, value))
            if got != expected:
                print(f"FAIL {step}: expected {expected}, got {got}")
                return 1
            print(f"{step}: {got}")
    finally:
        master.destroy()
    return 0


if __name__ == "__main__":
    sys.exit(main())
