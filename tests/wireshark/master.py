#!/usr/bin/env python3
"""A scripted DP master on the terminal of a running emulator: what it sends and receives is written down.

    master.py session TERMINAL LOG    every service, the parameter channel, a travel, and things that are wrong
    master.py forever TERMINAL LOG    Data_Exchange until nobody answers any more

Each line of LOG is one telegram: 1 and what was sent, or 0 and what was received (the directions of a capture made by
the emulator: inbound, outbound), in hex. Needs nothing but Python.
"""

import os
import select
import sys
import termios
import time
import tty

SLAVE, MASTER = 5, 2
SRD, SDN = 0x4D, 0x46
FCB, FCV = 0x20, 0x10
IDENT = bytes([0x0A, 0xC5])
PRM = bytes([0x80, 1, 1, 11]) + IDENT + bytes([1])  # lock, no watchdog, group 1
CFG = bytes([0xF3, 0xF2])


def telegram(da, sa, fc, pdu=b""):
    body = bytes([da, sa, fc]) + pdu
    end = bytes([sum(body) % 256, 0x16])
    if not pdu:
        return b"\x10" + body + end
    return bytes([0x68, len(body), len(body), 0x68]) + body + end


def sd3(da, sa, fc, pdu):
    body = bytes([da, sa, fc]) + pdu
    return b"\xa2" + body + bytes([sum(body) % 256, 0x16])


def length(octets):
    """How long the telegram at the front of the octets is, None if that is not known yet."""
    if octets[0] == 0x68:
        return octets[1] + 6 if len(octets) > 1 else None
    return {0x10: 6, 0xA2: 14, 0xE5: 1, 0xDC: 3}.get(octets[0], 1)


class Master:
    def __init__(self, terminal, log):
        self.line = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.line, termios.TCSANOW)
        self.log = log
        self.code = SRD | FCB
        self.last = b""

    def note(self, direction, octets):
        self.log.write(f"{direction} {octets.hex()}\n")
        self.log.flush()

    def send(self, octets, patience=10.0):
        """Sends octets and returns the telegram that comes back, None if none comes."""
        self.note(1, octets)
        os.write(self.line, octets)
        held, end = b"", time.monotonic() + patience
        while not held or (length(held) or 256) > len(held):
            left = end - time.monotonic()
            if left <= 0 or not select.select([self.line], [], [], left)[0]:
                break
            octets = os.read(self.line, 256)
            if not octets:
                raise OSError("end of file")
            held += octets
        if held:
            self.note(0, held)
        return held or None

    def silent(self, octets):
        """Sends what nobody answers, longer than a broken telegram lives."""
        assert self.send(octets, 0.1) is None

    def srd(self, sap, data=b""):
        """A request with the next frame count; sap None is Data_Exchange."""
        saps = b"" if sap is None else bytes([sap, 62])
        mark = 0 if sap is None else 0x80
        self.last = telegram(SLAVE | mark, MASTER | mark, self.code, saps + data)
        self.code = SRD | FCV | (0 if self.code & FCB else FCB)
        return self.send(self.last)

    def retry(self):
        return self.send(self.last)

    def exchange(self, pkw=bytes(8), stw=0, hsw=0):
        """One Data_Exchange with the words of PKW, STW and HSW; returns the inputs."""
        reply = self.srd(None, pkw + stw.to_bytes(2, "big") + hsw.to_bytes(4, "big", signed=True))
        if reply is None or len(reply) != 23:
            sys.exit(f"no inputs but {reply}")
        return reply[7:-2]

    def job(self, *words):
        """Runs a job of the parameter channel until its answer is there."""
        pkw = b"".join(word.to_bytes(2, "big") for word in words)
        for outputs, answered in ((bytes(8), False), (pkw, True)):
            while (self.exchange(outputs)[:8] != bytes(8)) != answered:
                time.sleep(0.005)  # some application cycles of the drive

    def start_up(self):
        self.srd(61, PRM)
        self.srd(62, CFG)
        self.srd(60)

    def travel(self, target, stw=0x007B):
        """Starts a travel job and waits until the shaft stands there (ZSW.10)."""
        while not self.exchange(stw=stw, hsw=target)[8] & 0x04:
            time.sleep(0.05)


def session(master):
    fdl_status = telegram(SLAVE, MASTER, 0x49)
    master.send(fdl_status)
    master.silent(telegram(9, MASTER, 0x49))  # nobody there
    master.silent(bytes([0xDC, 3, MASTER]))  # a token
    master.srd(60)
    master.srd(59)  # Get_Cfg
    master.srd(61, PRM[:4] + bytes([0x12, 0x34, 0]))  # another ident number
    master.srd(60)
    master.srd(61, bytes([0xB8, 2, 50, 11]) + IDENT + bytes([1, 0xAB]))  # Sync, Freeze, watchdog; too long
    master.srd(60)
    master.srd(61, PRM)
    master.srd(62, bytes([0xF3, 0xF1]))  # PPO type 1
    master.srd(60)
    master.srd(62, bytes([0xC1, 0x83, 0x45, 0x07]))  # special format, in the wrong state
    master.start_up()
    master.silent(telegram(0xFF, MASTER | 0x80, SDN, bytes([58, 62, 0, 0])))  # Operate
    master.exchange()
    master.retry()
    master.job(0x13A2, 0, 0, 0)  # read 930
    master.job(0x13F9, 0, 0, 0)  # read limit 2, negative
    master.job(0x33F8, 0, 0x0003, 0xD090)  # limit 1 = 250000
    master.job(0x23EB, 0, 0, 101)  # too large
    master.job(0x13E7, 0, 0, 0)  # no such parameter
    master.job(0x93B1, 0, 0, 0)  # elements of the fault buffer
    master.exchange(stw=0x0003)
    while not master.exchange(stw=0x003B)[8] & 0x80:  # ready to travel
        time.sleep(0.005)
    master.travel(100)
    master.srd(56)
    master.srd(57)
    master.silent(telegram(0xFF, MASTER | 0x80, SDN, bytes([58, 62, 0x28, 1])))  # Sync, Freeze for group 1
    master.silent(telegram(0xFF, MASTER | 0x80, SDN, bytes([58, 62, 0x16, 0])))  # the opposite, and Clear_Data
    master.srd(55, bytes([7]) + IDENT + bytes([0]))  # Set_Slave_Add: not supported
    master.srd(40)  # no such service
    master.srd(61, bytes([0x48, 1, 1]))  # Set_Prm that is too short
    master.srd(60)
    wrong = bytearray(fdl_status)
    wrong[4] += 1
    master.silent(bytes(wrong))  # FCS
    master.silent(fdl_status[:4])  # broken off
    master.silent(bytes([0x68, 0x05, 0x06, 0x68]))  # LEr
    master.silent(bytes.fromhex("00ff55"))  # noise
    others(master)
    master.send(telegram(SLAVE, MASTER, 0x4E))  # ident
    master.send(fdl_status)
    master.send(fdl_status)


def others(master):
    """What another master and its slave say to each other; the emulator only listens."""
    saps = bytes([62, 60])
    blocks = bytes.fromhex("04010203" "420f" "8341a1" "c5" "3f00")  # device, identifier, channel, revision, cut short
    diagnosis = bytes.fromhex("080c80031234") + blocks
    identifiers = bytes.fromhex("c18345aa" "00" "9f" "4f07" "c0")  # special, empty slot, general, special, cut short
    inputs = bytes.fromhex("43b1030000000041" "3b0b" "fffffc18")  # a fault; at -1000
    for request, response in (
        (telegram(0x87, 0x83, 0x6D, saps[::-1]), telegram(0x83, 0x87, 0x08, saps + diagnosis)),
        (telegram(0x87, 0x83, 0x5D, bytes([59, 62])), telegram(0x83, 0x87, 0x08, bytes([62, 59]) + identifiers)),
        (telegram(7, 3, 0x7D, bytes.fromhex("63b1030000000000" "820b" "00000000")), telegram(3, 7, 0x0A, inputs)),
        (sd3(7, 3, 0x5D, bytes(range(8))), b"\xe5"),
        (telegram(7, 3, 0x7D, bytes(7)), telegram(3, 7, 0x02)),
        (telegram(0x87, 3, 0x5D, bytes([61])), telegram(3, 8, 0x00)),  # no data; a reply of somebody else
        (telegram(0x87, 3, 0x5D), b""),  # no extension octet
    ):
        master.note(1, request)
        os.write(master.line, request)
        time.sleep(0.02)
        if response:
            master.silent(response)


def forever(master):
    master.start_up()
    value = 0
    while True:
        master.exchange(hsw=value)
        value += 1


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("session", "forever"):
        sys.exit(__doc__)
    with open(sys.argv[3], "w", encoding="ascii") as log:
        master = Master(sys.argv[2], log)
        try:
            (session if sys.argv[1] == "session" else forever)(master)
        except OSError as error:
            if sys.argv[1] == "session":
                raise
            print(f"the terminal is gone: {error}", file=sys.stderr)


if __name__ == "__main__":
    main()
