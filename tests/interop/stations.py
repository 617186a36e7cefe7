#!/usr/bin/env python3
"""Bring stations from GSDs into Data_Exchange with pyprofibus 1.13, which reads the same files with its own parser.

    stations.py --link pty:PATH|tcp:HOST:PORT --gsd DIRECTORY              all kinds of stations, at addresses 10, 11, ...
    stations.py --link ... --gsd DIRECTORY --wrong                         a module that the station does not take
    stations.py --link ... --gsd DIRECTORY --tank                          fill and drain the tank of examples/tank.py
    stations.py --link ... --gsd DIRECTORY --line-file                         the 12 stations of examples/line
    stations.py --list                                                     address and file of every station

Exit status 0 if all went well, 1 with one line `FAIL ...` otherwise.
"""

import argparse
import io
import socket
import sys
import time

from pyprofibus.conf import PbConf
from pyprofibus.fdl import FdlTelegram
from pyprofibus.phy import CpPhy

BAUD = 500000
LIMIT = 60.0  # seconds; only what fails takes so long

# File, modules, octets out and in; and user parameters where pyprofibus has none of its own: it knows no
# Ext_User_Prm_Data_Ref.
STATIONS = [
    ("compact.gsd", [], 12, 12, None),
    ("modular.gsd", ["2 out, 1 in", "empty slot", "2 inputs", "2 in, 2 out"], 4, 5, None),
    ("slots.gsd", ["out", "both"], 2, 1, None),
    ("preset.gsd", ["valves"], 2, 1, None),
    ("extended_prm.gsd", ["1 in, 1 out"], 1, 1, "80 59 FF FE"),
    ("unit_diag.gsd", [], 2, 8, None),
    ("dpv1.gsd", ["p", "q", "p"], 1, 2, None),
    ("remote_io.gsd", ["8 DI", "8 DO", "2 AI", "2 AO"], 5, 5, None),
]
REMOTE_IO = 7

# the line of examples/line/line.toml: the drives as their own GSD has them.
LINE = [
    (3, ("../../gsd/SIKO0AC5.GSD", ["PKW 4 words + PZD 3 words"], 14, 14, None)),
    (4, ("../../gsd/SIKO0AC5.GSD", ["PKW 4 words + PZD 3 words"], 14, 14, None)),
    *[(address, ("io.gsd", ["8 DI", "8 DO", "2 AI"], 1, 5, None)) for address in range(5, 11)],
    *[(address, ("valves.gsd", [], 2, 1, None)) for address in (11, 12)],
    *[(address, ("scale.gsd", [], 1, 5, None)) for address in (13, 14)],
]


class CpPhyTcp(CpPhy):
    """A line behind a TCP port: telegrams as they are."""

    def __init__(self, host, port):
        super().__init__(debug=False)
        self.socket = socket.create_connection((host, port), timeout=LIMIT)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.octets = bytearray()

    def close(self):
        self.socket.close()
        super().close()

    def sendData(self, telegramData, srd):
        self.socket.sendall(bytes(telegramData))

    def pollData(self, timeout=0.0):
        self.socket.settimeout(max(timeout, 0.0001))
        try:
            while True:
                size = FdlTelegram.getSizeFromRaw(self.octets) if self.octets else -1
                if 0 < size <= len(self.octets):
                    telegram, self.octets = self.octets[:size], self.octets[size:]
                    return telegram
                self.octets += self.socket.recv(512)
        except (TimeoutError, socket.timeout):
            return None


class Failure(Exception):
    """A step did not go as it must."""


def configuration(link, gsd, stations):
    """pyprofibus' own form. Sizes are seen from the slave: input_size is what the master sends."""
    kind, _, place = link.partition(":")
    text = f"[PROFIBUS]\ndebug=0\n[PHY]\ntype=serial\ndev={place}\nbaud={BAUD}\n[DP]\nmaster_class=1\nmaster_addr=2\n"
    for number, (address, (file, modules, outputs, inputs, _)) in enumerate(stations):
        text += f"[SLAVE_{number}]\nname={file}\naddr={address}\ngsd={gsd}/{file}\nsync_mode=0\nfreeze_mode=0\n"
        text += f"group_mask=0\nwatchdog_ms=5000\ninput_size={outputs}\noutput_size={inputs}\n"
        text += "".join(f"module_{place}={name}\n" for place, name in enumerate(modules))
    conf = PbConf(io.StringIO(text))
    phy = None
    if kind == "tcp":
        host, _, port = place.rpartition(":")
        phy = CpPhyTcp(host, int(port))
        phy.setConfig(baudrate=BAUD)
    return conf, conf.makeDPM(phy)


class Line:
    """A master and its stations."""

    def __init__(self, link, gsd, stations):
        conf, self.master = configuration(link, gsd, stations)
        self.slaves = {}
        for slave_conf, (address, row) in zip(conf.slaveConfs, stations):
            slave = slave_conf.makeDpSlaveDesc()
            if row[4] is not None:
                slave.setUserPrmData(bytes.fromhex(row[4]))
            self.master.addSlave(slave)
            self.slaves[address] = slave
        self.master.initialize()
        self.inputs, self.outputs = {}, {}

    def until(self, what, done):
        """Lets the master run until `done` is true."""
        end = time.monotonic() + LIMIT
        while not done():
            if time.monotonic() > end:
                raise Failure(f"{what}: not within {LIMIT} s; inputs {self.inputs}")
            # pyprofibus exchanges data only with those that have new outputs.
            for address, octets in self.outputs.items():
                self.slaves[address].setMasterOutData(octets)
            self.master.run()
            for address, slave in self.slaves.items():
                data = slave.getMasterInData()
                if data is not None:
                    self.inputs[address] = bytes(data)
            time.sleep(0.0002)

    def send(self, address, octets):
        self.outputs[address] = bytearray(octets)


def every_kind(link, gsd):
    stations = list(enumerate(STATIONS, 10))
    line = Line(link, gsd, stations)
    for address, (_, _, outputs, _, _) in stations:
        line.send(address, range(1, outputs + 1))
    line.until("Data_Exchange", lambda: all(slave.isConnected() for slave in line.slaves.values()))
    # A station without outputs has its inputs read all the same.
    wanted = {address: row[3] for address, row in stations}
    line.until("inputs", lambda: {address: len(octets) for address, octets in line.inputs.items()} == wanted)
    for address, row in stations:
        print(f"station {address}: {row[0]}, {row[2]} octets out, {row[3]} in")
    line.master.destroy()


def line_file(link, gsd):
    line = Line(link, gsd, LINE)
    for address, (_, _, outputs, _, _) in LINE:
        line.send(address, bytes(outputs))
    line.until("Data_Exchange", lambda: all(slave.isConnected() for slave in line.slaves.values()))
    line.send(5, [1])
    line.send(6, [0xA5])
    line.until("a mirrored output", lambda: line.inputs.get(5, b"\0")[0] == 1)
    line.until("an output that another station follows", lambda: line.inputs.get(7, b"\0")[0] == 0xA5)
    line.until("a constant", lambda: line.inputs.get(11, b"\0")[0] == 129)
    print(f"line: {len(LINE)} stations exchange data")
    line.master.destroy()


def wrong(link, gsd):
    row = STATIONS[REMOTE_IO]
    line = Line(link, gsd, [(10, (row[0], ["2 AO"] * 9, 36, 1, None))])
    end = time.monotonic() + 3
    while time.monotonic() < end:
        line.master.run()
        if line.slaves[10].isConnected():
            raise Failure("nine modules: expected a refusal, got Data_Exchange")
        time.sleep(0.0002)
    line.master.destroy()


def tank(link, gsd):
    line = Line(link, gsd, [(7, STATIONS[REMOTE_IO])])

    def level():
        return int.from_bytes(line.inputs.get(7, bytes(5))[1:3], "big")

    for what, octet, done in [
        ("empty", 0, lambda: line.inputs.get(7, b"\0")[0] & 2),
        ("fill", 1, lambda: level() > 9000),
        ("drain", 2, lambda: level() == 0 and line.inputs[7][0] & 2),
    ]:
        line.send(7, [octet, 0, 0, 0, 0])
        line.until(what, done)
        print(f"{what}: level {level()}, switches {line.inputs[7][0]:02b}")
    line.master.destroy()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--link")
    parser.add_argument("--gsd")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--wrong", action="store_true")
    parser.add_argument("--tank", action="store_true")
    parser.add_argument("--line-file", action="store_true")
    args = parser.parse_args()
    if args.list:
        print("\n".join(f"{address} {row[0]}" for address, row in enumerate(STATIONS, 10)))
        return 0
    play = wrong if args.wrong else tank if args.tank else line_file if args.line_file else every_kind
    try:
        play(args.link, args.gsd)
    except Failure as failure:
        print(f"FAIL {failure}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
