"""The master under test: here pyprofibus 1.13, with one drive at address 5. Put yours in its place."""

import io
import struct
import sys
import time
from pathlib import Path

from pyprofibus.conf import PbConf

PROJECT = """
[PROFIBUS]
[PHY]
type=serial
dev={port}
baud=19200
[DP]
master_class=1
master_addr=2
[SLAVE_0]
addr=5
gsd={gsd}
watchdog_ms=5000
input_size=14
output_size=14
"""
GSD = Path(__file__).resolve().parents[2] / "gsd" / "SIKO0AC5.GSD"


class Drive:
    """Seven words out (PKE IND PWE PWE STW HSW HSW), seven words in (PKE IND PWE PWE ZSW HIW HIW)."""

    def __init__(self, port):
        project = PbConf(io.StringIO(PROJECT.format(port=port, gsd=GSD)))
        self.master, self.slave = project.makeDPM(), project.slaveConfs[0].makeDpSlaveDesc()
        self.master.addSlave(self.slave)
        self.master.initialize()
        self.job, self.stw, self.target = (0, 0, 0), 0, 0
        self.answer, self.zsw, self.position = (0, 0, 0), 0, 0

    def until(self, what, condition, limit=20):
        """Exchanges data until the inputs meet a condition."""
        end = time.monotonic() + limit
        while time.monotonic() < end:
            self.slave.setMasterOutData(struct.pack(">HHLHl", *self.job, self.stw, self.target))
            self.master.run()
            if inputs := self.slave.getMasterInData():
                *self.answer, self.zsw, self.position = struct.unpack(">HHLHl", bytes(inputs))
                if condition():
                    print(f"{what}: ZSW {self.zsw:04X}, position {self.position}")
                    return
        sys.exit(f"FAIL {what}: not within {limit} s, ZSW {self.zsw:04X}, position {self.position}")

    def read(self, pnu, job=1):
        """Reads a parameter through the parameter channel; job 6 reads the newest element of an array."""
        self.job = (job << 12 | pnu, 0, 0)
        self.until(f"read {pnu}", lambda: self.answer[0] >> 12 and self.answer[0] & 0x7FF == pnu)
        return self.answer[2]
