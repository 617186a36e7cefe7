#!/usr/bin/env python3
"""Data_Exchange of a master beside a client that sends random octets, on one TCP port of `profidrive emulate`.

    cargo build --release --features cli
    python3 benches/noise.py target/release/profidrive

The client sends as many octets as a line of 12 Mbit/s carries, for more it would be dropped. Pairs of rounds of 2 s, without
and with noise: exchanges per second of both, their ratio, and how many requests stayed unanswered. Exit status 1 if a request
stayed unanswered or the median of the ratios is below one half.
"""

import multiprocessing
import os
import select
import socket
import statistics
import sys
import tempfile
import time

from scale import Line

SECONDS = 2.0
PAIRS = 7
# Octets in a second: one hundredth less than 12 Mbit/s carry, with 11 bits for each.
CAP = 1_080_000
# What a request waits for its reply before it counts as unanswered.
PATIENCE = 1.0


def reply_of(drive):
    """The beginning of its reply to Data_Exchange with 14 octets; by chance noise has it once in 2000 years."""
    return bytes([0x68, 17, 17, 0x68, 2, drive, 0x08])


class Master:
    """The connection of a line, on which noise lies between the telegrams."""

    def __init__(self, line):
        self.line, self.drive = line, line.drives[0]

    def round(self):
        """Exchanges in a second, and how many requests stayed unanswered."""
        exchanges = unanswered = 0
        begin = time.monotonic()
        while (now := time.monotonic()) < begin + SECONDS:
            self.line.socket.sendall(self.line.request(self.drive, 0x003B, 0))
            if self.hears_reply(now + PATIENCE):
                exchanges += 1
            else:
                unanswered += 1
        return exchanges / (time.monotonic() - begin), unanswered

    def hears_reply(self, until):
        octets, header = b"", reply_of(self.drive)
        while True:
            at = octets.find(header)
            if at >= 0 and len(octets) >= at + 23:
                return True
            if not select.select([self.line.socket], [], [], max(0.0, until - time.monotonic()))[0]:
                return False
            octets += self.line.socket.recv(65536)

    def drain(self):
        while select.select([self.line.socket], [], [], 0.2)[0]:
            self.line.socket.recv(65536)


def make_noise(place, on, sent, failed):
    """The process of the client: sends while `on` is set, and reads what it hears."""
    connection = socket.create_connection(place)
    while True:
        on.wait()
        begin, count = time.monotonic(), 0
        while on.is_set():
            while select.select([connection], [], [], 0)[0]:
                if not connection.recv(65536):
                    failed.set()
                    return
            due = int((time.monotonic() - begin) * CAP) - count
            if due > 0:
                connection.sendall(os.urandom(min(due, 16384)))
                count += min(due, 16384)
            time.sleep(0.0005)
        sent.value = int(count / (time.monotonic() - begin))


def main():
    program = os.path.abspath(sys.argv[1])
    on, failed, sent = multiprocessing.Event(), multiprocessing.Event(), multiprocessing.Value("q", 0)
    with tempfile.TemporaryDirectory() as folder:
        line = Line(program, folder, 0, 1, panel=False, core=None)
        line.start()
        master = Master(line)
        noise = multiprocessing.Process(target=make_noise, args=(line.place, on, sent, failed), daemon=True)
        noise.start()
        ratios, lost = [], 0
        print("| alone | beside noise | ratio | octets of noise in a second | unanswered |")
        print("| --- | --- | --- | --- | --- |")
        for _ in range(PAIRS):
            alone, unanswered = master.round()
            on.set()
            beside, more = master.round()
            on.clear()
            master.drain()
            if failed.is_set():
                sys.exit("the client of noise was dropped")
            ratios.append(beside / alone)
            lost += unanswered + more
            print(f"| {alone:.0f}/s | {beside:.0f}/s | {ratios[-1]:.2f} | {sent.value} | {unanswered + more} |", flush=True)
        line.end()
    print(f"median of the ratios {statistics.median(ratios):.2f}, unanswered {lost}")
    sys.exit(lost > 0 or statistics.median(ratios) < 0.5)


main()
