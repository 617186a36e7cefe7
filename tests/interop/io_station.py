#!/usr/bin/env python3
"""Exchange data with an I/O station of one octet out, one octet and one word in (gsd/PDRV494F.GSD) with pyprofibus 1.13.

The station is the firmware of examples/firmware or the page docs/build-your-own-slave.md. Its inputs are wired to its outputs, its
word counts, and while output 8 is on its diagnosis names a short circuit.

Exit status 0 if all went well, 1 with one line `FAIL step: expected ..., got ...` otherwise.
"""

import argparse
import io
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
name=io
addr={address}
gsd={gsd}
sync_mode=0
freeze_mode=0
group_mask=1
watchdog_ms=1000
input_size=1
output_size=3
"""

LIMIT = 15.0  # seconds for the start-up and for each step
SHORT_CIRCUIT = bytes.fromhex("80 87 21")  # module 0; output, channel 7; one bit, error 1


class Failure(Exception):
    """A step did not go as it must."""


class Station:
    def __init__(self, args):
        conf = PbConf(io.StringIO(CONFIGURATION.format(**vars(args))))
        self.master = conf.makeDPM()
        self.slave = conf.slaveConfs[0].makeDpSlaveDesc()
        self.diagnosis = b""
        # pyprofibus keeps no extended diagnosis: it is read where it passes.
        phy = type(self.master.phy)
        received = phy.pollData

        def poll(*arguments, **named):
            data = received(*arguments, **named)
            if data is not None and SHORT_CIRCUIT in bytes(data):
                self.diagnosis = bytes(data)
            return data

        phy.pollData = poll
        self.master.addSlave(self.slave)
        self.master.initialize()

    def until(self, step, output, done, expected):
        end = time.monotonic() + LIMIT
        inputs = None
        while time.monotonic() < end:
            self.slave.setMasterOutData(bytearray([output]))
            self.master.run()
            inputs = self.slave.getMasterInData() or inputs
            if inputs is not None and done(bytes(inputs)):
                print(f"{step}: inputs {bytes(inputs).hex(' ')}")
                return bytes(inputs)
            time.sleep(0.0003)
        raise Failure(f"FAIL {step}: expected {expected}, got {inputs and bytes(inputs).hex(' ')}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", required=True)
    parser.add_argument("--baud", default="500000")
    parser.add_argument("--gsd", required=True)
    parser.add_argument("--address", type=int, default=7)
    args = parser.parse_args()
    station = Station(args)
    try:
        for output in (0x01, 0x55, 0x2A):
            station.until(f"output {output:02X}", output, lambda data: data[0] == output, "the same as input")
        first = station.until("the counter", 0x2A, lambda data: True, "a word")[1:]
        station.until("the counter goes on", 0x2A, lambda data: data[1:] != first, f"another word than {first.hex()}")
        station.until("output 8", 0x80, lambda _: station.diagnosis, "a diagnosis with a short circuit")
        station.until("back", 0x01, lambda data: data[0] == 1, "the same as input")
    except Failure as failure:
        print(failure)
        return 1
    finally:
        station.master.destroy()
    return 0


if __name__ == "__main__":
    sys.exit(main())
