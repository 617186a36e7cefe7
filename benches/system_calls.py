#!/usr/bin/env python3
"""System calls and processor time of `profidrive emulate` for an exchange: one drive, or an SDO of one node.

    cargo build --release --features cli
    python3 benches/system_calls.py target/release/profidrive

The master is here. Calls are counted by strace in one run, processor time is read from /proc in others without it: the least
of ROUNDS, because other work on the machine lengthens it. An SDO waits for its frames on the bus, and to be woken is most of
what it costs; the drives reply at once. Exit status 1 if an exchange takes more than 5 system calls on average, or one of a
drive more than 25 us.
"""

import os
import subprocess
import sys
import tempfile
import termios
import time
import tty
from pathlib import Path

from scale import CanLine, Line

EXCHANGES = 2000
ROUNDS = 20
MOST_CALLS = 5.0
MOST_SECONDS = 25e-6


class Terminal:
    """The end of a master at a terminal, with the face of a socket."""

    def __init__(self, path):
        self.file = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.file, termios.TCSANOW)

    def sendall(self, octets):
        os.write(self.file, octets)

    def recv(self, most):
        return os.read(self.file, most)


class AtTerminal:
    """A line whose link is a terminal."""

    def emulate(self, program, folder, number, _panel, _core, link, participants):
        path = Path(folder, f"bus{number}")
        file = Path(folder, f"line{number}.toml")
        file.write_text(f'[[line]]\nlink = "{link.replace("tcp", "pty")}:{path}"\n' + participants)
        self.process = subprocess.Popen(
            [program, "emulate", "--quiet", "--line", str(file)], stdout=subprocess.PIPE, text=True
        )
        self.process.stdout.readline()
        self.place, self.exchanges = path, 0

    def connect(self):
        self.socket = Terminal(self.place)
        # Its settings are looked at for some milliseconds.
        time.sleep(0.2)


class Sdo(CanLine):
    """The one exchange is an upload of 1018h:1."""

    def request(self, _drive, _stw, _setpoint):
        return b"t60184018100100000000\r"

    def reply_in(self, octets):
        """The adapter's word, and the frame."""
        return len(octets) if octets.count(b"\r") >= 2 else 0

    def start(self):
        self.connect()
        self.socket.sendall(b"O\r")
        time.sleep(0.5)
        self.socket.recv(65536)
        self.exchange(None, 0, 0)


class DriveAtTerminal(AtTerminal, Line):
    pass


class SdoAtTerminal(AtTerminal, Sdo):
    pass


def calls(line):
    """How many of each, for all exchanges."""
    with tempfile.NamedTemporaryFile() as told:
        arguments = ["strace", "--follow-forks", "--summary-only", "--output", told.name, "--attach", str(line.process.pid)]
        tracer = subprocess.Popen(arguments, stderr=subprocess.PIPE)
        # It says that it is there.
        tracer.stderr.readline()
        run(line)
        tracer.terminate()
        tracer.wait(10)
        rows = [row.split() for row in Path(told.name).read_text().splitlines()]
    return {row[-1]: int(row[3]) for row in rows if len(row) > 4 and row[3].isdigit() and row[-1] != "total"}


def run(line, exchanges=EXCHANGES):
    for _ in range(exchanges):
        line.exchange(line.drives[0], 0x003B, 0)


def timed(line):
    """Seconds of processor time, and seconds, for an exchange."""
    before, since = line.processor(), time.monotonic()
    run(line, EXCHANGES // ROUNDS)
    lasted = time.monotonic() - since
    return (line.processor() - before) * ROUNDS / EXCHANGES, lasted * ROUNDS / EXCHANGES


def measure(program, kind, name):
    """A row of the table; whether it is within what is wanted."""
    with tempfile.TemporaryDirectory() as folder:
        line = kind(program, folder, 0, 1, False, None)
        line.start()
        run(line)
        rounds = [timed(line) for _ in range(ROUNDS)]
        counted = calls(line)
        line.end()
    used, lasted = (min(column) for column in zip(*rounds))
    each = sum(counted.values()) / EXCHANGES
    most = ", ".join(f"{call} {count / EXCHANGES:.2f}" for call, count in sorted(counted.items(), key=lambda row: -row[1])[:6])
    print(f"| {name} | {each:.2f} | {used * 1e6:.1f} us | {1 / lasted:.0f}/s | {most} |", flush=True)
    return each <= MOST_CALLS and (issubclass(kind, Sdo) or used <= MOST_SECONDS)


def table(program):
    """Prints the table; whether everything is within what is wanted."""
    print("| exchange | system calls | processor time | exchanges | calls of each kind |")
    print("| --- | --- | --- | --- | --- |")
    kinds = [(Line, "drive, TCP"), (DriveAtTerminal, "drive, terminal"), (Sdo, "SDO, slcan on TCP"), (SdoAtTerminal, "SDO, slcan on a terminal")]
    return all([measure(program, kind, name) for kind, name in kinds])


if __name__ == "__main__":
    sys.exit(0 if table(os.path.abspath(sys.argv[1])) else 1)
