#!/usr/bin/env python3
"""What a line costs: processor time and memory of `profidrive emulate --line`, several processes, idle and polled.

    cargo build --release --features cli
    python3 benches/scale.py target/release/profidrive

Each line is a process of its own with drives on TCP, as in docs/scale.md. The master is here: it starts each drive and
exchanges data with all of them once in a cycle, travelling drives included. Lines of CANopen nodes are AP10s behind an
slcan adapter on TCP: one SYNC in a cycle, and a TPDO of each node. The last table is that of system_calls.py, if strace is
there: system calls and processor time of one exchange. Processor time is that of the emulators alone, from
/proc, so that other work on the machine lengthens it little (caches and shared cores do).
"""

import os
import re
import selectors
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SECONDS = 5.0


def sd2(to, control, data, saps=b""):
    """A telegram of master 2; the SAPs are DSAP and SSAP."""
    extension = 0x80 if saps else 0
    body = bytes([to | extension, 2 | extension, control]) + saps + data
    return bytes([0x68, len(body), len(body), 0x68]) + body + bytes([sum(body) & 0xFF, 0x16])


def reply_in(octets):
    """How long the telegram at the beginning is, 0 if it is not whole."""
    match octets[:1]:
        case b"":
            return 0
        case b"\xe5":
            return 1
        case b"\x68":
            whole = octets[1] + 6 if len(octets) > 1 else 256
        case other:
            sys.exit(f"the emulator sent {other.hex()}")
    return whole if len(octets) >= whole else 0


class Line:
    """One process with its drives, and the connection of the master to it."""

    def __init__(self, program, folder, number, drives, panel, core):
        self.drives = [address for address in range(126) if address != 2][-drives:]
        participants = "".join(f"\n[[line.drive]]\naddress = {address}\n" for address in self.drives)
        self.emulate(program, folder, number, panel, core, "tcp", participants)
        self.bit = dict.fromkeys(self.drives, 0)

    def emulate(self, program, folder, number, panel, core, link, participants):
        """Starts the process."""
        text = f'[[line]]\nlink = "{link}:127.0.0.1:0"\n' + ('panel = "127.0.0.1:0"\n' if panel else "")
        file = Path(folder, f"line{number}.toml")
        file.write_text(text + participants)
        arguments = [program, "emulate", "--quiet", "--line", str(file)]
        if core is not None:
            arguments = ["taskset", "--cpu-list", str(core), *arguments]
        self.process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        place = re.search(r"link=[a-z-]*tcp:(\S+):(\d+)", self.process.stdout.readline())
        self.place = place[1], int(place[2])
        self.exchanges = 0

    def connect(self):
        self.socket = socket.create_connection(self.place)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def start(self):
        """Takes every drive into Data_Exchange."""
        self.connect()
        for drive in self.drives:
            self.ask(sd2(drive, 0x6D, b"", b"\x3c\x3e"))
            self.ask(sd2(drive, 0x5D, bytes.fromhex("88 FF FF 0B 0A C5 00"), b"\x3d\x3e"))
            self.ask(sd2(drive, 0x7D, bytes.fromhex("F3 F2"), b"\x3e\x3e"))
            for bit in 0x5D, 0x7D, 0x5D, 0x7D:
                diagnosis = self.ask(sd2(drive, bit, b"", b"\x3c\x3e"))
                if not diagnosis[9] & 0x0A:
                    break
            assert not diagnosis[9] & 0x4A and not diagnosis[10] & 1, f"drive {drive}: {diagnosis.hex(' ')}"
            for words in (0x0000, 0x003B):
                self.exchange(drive, words, 0)

    def ask(self, telegram):
        self.socket.sendall(telegram)
        octets = b""
        while not (whole := self.reply_in(octets)):
            octets += self.socket.recv(512)
        return octets[:whole]

    def reply_in(self, octets):
        return reply_in(octets)

    def request(self, drive, stw, setpoint):
        self.bit[drive] ^= 0x20
        outputs = bytes(8) + struct.pack(">Hl", stw, setpoint)
        return sd2(drive, 0x5D ^ self.bit[drive], outputs)

    def exchange(self, drive, stw, setpoint):
        self.exchanges += 1
        return self.ask(self.request(drive, stw, setpoint))

    def processor(self):
        """Seconds of processor time, the kernel's part included."""
        tasks = Path(f"/proc/{self.process.pid}/task").iterdir()
        return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks) / 1e9

    def memory(self):
        """Resident, and of that what no other process shares, in KiB."""
        text = Path(f"/proc/{self.process.pid}/smaps_rollup").read_text()
        return [int(re.search(rf"^{key}:\s+(\d+)", text, re.M)[1]) for key in ("Rss", "Private_Dirty")]

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(20) == 0


class CanLine(Line):
    """One process with AP10s at a CAN bus. Its one exchange is SYNC and TPDO 2 of each node."""

    def __init__(self, program, folder, number, nodes, panel, core):
        self.nodes, self.drives = nodes, ["SYNC"]
        participants = "".join(f'\n[[line.node]]\nid = {node}\ndevice = "ap10"\n' for node in range(1, nodes + 1))
        self.emulate(program, folder, number, panel, core, "slcan-tcp", participants)

    def start(self):
        """Opens the adapter and starts all nodes."""
        self.connect()
        self.socket.sendall(b"O\rt00020100\r")
        # Nodes that were switched on just now still say so. Each line ends with CR.
        time.sleep(0.5)
        self.socket.recv(65536)
        self.exchange(None, 0, 0)

    def reply_in(self, octets):
        """The adapter's word, and a frame of each node."""
        return len(octets) if octets.count(b"\r") > self.nodes else 0

    def request(self, _drive, _stw, _setpoint):
        return b"t0800\r"


def poll(lines, cycle, travelling):
    """Exchanges data with every drive of every line once in each cycle, the lines at the same time; for SECONDS."""
    goal = time.monotonic()
    end = goal + SECONDS
    selector = selectors.DefaultSelector()
    for line in lines:
        selector.register(line.socket, selectors.EVENT_READ, line)
    setpoint, stw = (900_000, 0x007B) if travelling else (0, 0x003B)
    cycles = 0
    while goal < end:
        cycles += 1
        waiting = {line: (iter(line.drives), b"") for line in lines}
        for line in lines:
            line.socket.sendall(line.request(next(waiting[line][0]), stw, setpoint))
        while waiting:
            for key, _ in selector.select(5.0) or sys.exit("no reply"):
                line = key.data
                rest, octets = waiting[line]
                octets += line.socket.recv(4096)
                if not line.reply_in(octets):
                    waiting[line] = rest, octets
                    continue
                line.exchanges += 1
                if (drive := next(rest, None)) is None:
                    del waiting[line]
                else:
                    waiting[line] = rest, b""
                    line.socket.sendall(line.request(drive, stw, setpoint))
        goal = max(goal + cycle, time.monotonic() - cycle)
        time.sleep(max(0.0, goal - time.monotonic()))


def measure(program, count, drives, cycle, panel=False, core=None, kind=Line):
    """Rows of `count` lines of `drives` drives, all on one core if it is named; without a cycle no master is there."""
    with tempfile.TemporaryDirectory() as folder:
        lines = [kind(program, folder, number, drives, panel, core) for number in range(count)]
        row = [f"{count}", f"{drives}", "yes" if panel else "no"]
        if cycle is None:
            time.sleep(0.5)
            before = sum(line.processor() for line in lines)
            time.sleep(SECONDS)
            used = sum(line.processor() for line in lines) - before
            show([*row, "no master", "", f"{used / SECONDS / count * 100:.3f} %", ""], lines)
        else:
            for line in lines:
                line.start()
            for travelling in [False, True] if kind is Line else [False]:
                before = sum(line.processor() for line in lines)
                exchanges, since = sum(line.exchanges for line in lines), time.monotonic()
                poll(lines, cycle, travelling)
                used = sum(line.processor() for line in lines) - before
                exchanges, lasted = sum(line.exchanges for line in lines) - exchanges, time.monotonic() - since
                what = f"{cycle * 1000:.0f} ms, {'travelling' if travelling else 'at standstill'}"
                costs = [f"{used / lasted / count * 100:.2f} %", f"{used / exchanges * 1e6:.1f} us"]
                show([*row, what, f"{exchanges / lasted:.0f}/s", *costs], lines)
        for line in lines:
            line.end()


def show(row, lines):
    memory = [line.memory() for line in lines]
    resident, own = (sum(column) / len(memory) for column in zip(*memory))
    print("| " + " | ".join([*row, f"{resident:.0f} KiB", f"{own:.0f} KiB"]) + " |", flush=True)


def main():
    program = os.path.abspath(sys.argv[1])
    print("| lines | drives on each | panel | cycle | exchanges of all | of a core, each line | an exchange | resident | its own |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for drives in 1, 5, 25, 125:
        measure(program, 1, drives, None)
    measure(program, 1, 5, None, panel=True)
    for count, drives, cycle in [(1, 1, 0.01), (1, 5, 0.01), (1, 25, 0.05), (1, 125, 0.25), (20, 5, 0.1)]:
        measure(program, count, drives, cycle)
    measure(program, 1, 5, 0.01, panel=True)
    # More and more lines on one core, until it carries no more: the exchanges say so.
    for count in 4, 8, 12, 16, 24:
        measure(program, count, 5, 0.01, core=0)
    print("\nCANopen:")
    for nodes in 1, 5, 25, 127:
        measure(program, 1, nodes, None, kind=CanLine)
    for nodes, cycle in [(1, 0.01), (5, 0.01), (25, 0.05), (127, 0.25)]:
        measure(program, 1, nodes, cycle, kind=CanLine)
    if shutil.which("strace"):
        import system_calls

        print("\nOne exchange:")
        system_calls.table(program)


if __name__ == "__main__":
    main()
