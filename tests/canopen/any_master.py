"""Any CANopen master at the node of tests/eds/terminal.eds, and what it did there, heard on the bus:

    any_master.py PROFIDRIVE COMMAND [ARGUMENT...]

runs `COMMAND [ARGUMENT...] HOST:PORT NODE EDS`, a master that speaks slcan on TCP and does, with the node,

- NMT: reset node, start
- SDO: an upload and a download of one frame each; the domain 2000h written and read in segments, and in blocks
- heartbeat: 1017h set to 20 ms, and 300 ms of it
- PDO: the outputs 6200h:01, 6200h:02 and 6411h:01 (INTEGER16) by the RPDO 205h, the last one then read by SDO; SYNC, that the
  TPDO 385h answers with 6200h:01 and 6411h:01

in any order. Exit status 0 if COMMAND ended with 0 and every service was heard and right. Needs nothing beside Python.
"""

import collections
import itertools
import pathlib
import socket
import subprocess
import sys
import threading
import time

NODE = 5
LIMIT = 60  # seconds for the master
SHEET = pathlib.Path(__file__).resolve().parents[1] / "eds" / "terminal.eds"
DOMAIN = (0x2000, 0)
OUTPUT = (0x6411, 1)
HEARTBEAT = (0x1017, 0)

Frame = collections.namedtuple("Frame", "at id data")
Transfer = collections.namedtuple("Transfer", "at kind object octets")


def listen(place, frames):
    """Hears the bus at an adapter of its own, until the emulator ends."""
    line = socket.create_connection(place)
    line.sendall(b"S6\rO\r")
    line.settimeout(5)
    assert line.recv(1) in (b"\r", b"\x07")

    def run():
        rest = b""
        line.settimeout(None)
        while octets := line.recv(4096):
            *lines, rest = (rest + octets).replace(b"\x07", b"\r").split(b"\r")
            now = time.monotonic()
            for text in lines:
                if text.startswith(b"t"):
                    # Frames that are read together are in order, too.
                    now += 1e-9
                    length = int(text[4:5])
                    frames.append(Frame(now, int(text[1:4], 16), bytes.fromhex(text[5 : 5 + 2 * length].decode())))

    threading.Thread(target=run, daemon=True).start()


class Transfers:
    """The SDO transfers of one client and one server that came to their end."""

    def __init__(self):
        self.done = []
        self.kind = self.object = None
        self.octets = b""
        self.segments = self.last = False

    def begin(self, kind, data, octets=b""):
        self.kind, self.object, self.octets = kind, (data[1] | data[2] << 8, data[3]), octets
        self.segments = self.last = False

    def finish(self, at):
        self.done.append(Transfer(at, self.kind, self.object, self.octets))
        self.kind = None

    def request(self, data):
        command, unused = data[0] >> 5, 7 - (data[0] >> 1 & 7)
        if self.kind == "block download" and self.segments:
            self.octets += data[1:]
            self.segments = data[0] < 0x80
        elif command == 1 and data[0] & 2:
            self.begin("expedited download", data, data[4 : 8 - (data[0] >> 2 & 3)])
        elif command == 1:
            self.begin("segmented download", data)
        elif command == 2:
            self.begin("upload", data)
        elif command == 0:
            self.octets += data[1 : 1 + unused]
            self.last = data[0] & 1
        elif command == 5 and data[0] & 3 == 0:
            self.begin("block upload", data)
        elif command == 5 and data[0] & 3 == 3:
            self.segments = True
        elif command == 6 and data[0] & 1 == 0:
            self.begin("block download", data)
        elif command == 6:
            self.octets = self.octets[: len(self.octets) - (data[0] >> 2 & 7)]

    def answer(self, at, data):
        command, unused = data[0] >> 5, 7 - (data[0] >> 1 & 7)
        if self.kind is None or data[0] == 0x80:
            self.kind = None
        elif self.kind == "block upload" and self.segments:
            self.octets += data[1:]
            self.segments = data[0] < 0x80
        elif self.kind == "block upload":
            if data[0] & 1:
                self.octets = self.octets[: len(self.octets) - (data[0] >> 2 & 7)]
                self.finish(at)
        elif self.kind == "block download":
            if data[0] & 3 == 0:
                self.segments = True
            elif data[0] & 3 == 1:
                self.finish(at)
        elif command == 3 and self.kind == "expedited download" or command == 1 and self.last:
            self.finish(at)
        elif command == 2 and data[0] & 2:
            self.kind, self.octets = "expedited upload", data[4 : 8 - (data[0] >> 2 & 3)]
            self.finish(at)
        elif command == 2:
            self.kind = "segmented upload"
        elif command == 0:
            self.octets += data[1 : 1 + unused]
            if data[0] & 1:
                self.finish(at)


def transfers(frames):
    watched = Transfers()
    for frame in frames:
        if frame.id == 0x600 + NODE:
            watched.request(frame.data)
        elif frame.id == 0x580 + NODE:
            watched.answer(frame.at, frame.data)
    return watched.done


def follows(frames, first, then, before=None):
    """Whether a frame like `first` has one like `then` behind it, with none like `before` between."""
    for place, frame in enumerate(frames):
        if first(frame):
            behind = itertools.takewhile(lambda other: not (before and before(other)), frames[place + 1 :])
            if any(then(other) for other in behind):
                return True
    return False


def command(number):
    return lambda frame: frame.id == 0 and frame.data in (bytes([number, NODE]), bytes([number, 0]))


def state(number):
    return lambda frame: frame.id == 0x700 + NODE and frame.data == bytes([number])


def beats(frames, done):
    """Whether there are ten heartbeats one behind the other as 1017h says, 20 ms."""
    since = [write.at for write in done if write.object == HEARTBEAT and write.octets == b"\x14\0"]
    times = [frame.at for frame in frames if since and frame.at > since[0] and frame.id == 0x700 + NODE]
    return any(0.15 < times[place + 9] - times[place] < 0.25 for place in range(len(times) - 9))


def is_received(frames, done):
    """Whether 6411h:01 reads as the RPDO before said."""
    for read in done:
        sent = [frame.data for frame in frames if frame.id == 0x200 + NODE and frame.at < read.at]
        if read.object == OUTPUT and "upload" in read.kind and sent and sent[-1][2:4] == read.octets:
            return True
    return False


def rows(frames):
    done = transfers(frames)
    yield "NMT reset node, boot-up", follows(frames, command(0x81), state(0))
    yield "NMT start, OPERATIONAL", follows(frames, command(1), state(5))
    for kind in ("expedited upload", "expedited download"):
        yield f"SDO {kind}", any(transfer.kind == kind for transfer in done)
    domains = [transfer for transfer in done if transfer.object == DOMAIN]
    for way in ("segmented", "block"):
        written = [transfer for transfer in domains if transfer.kind == f"{way} download" and len(transfer.octets) > 100]
        yield f"SDO {way} download, more than 100 octets", bool(written)
        held = {}
        right = False
        for transfer in domains:
            if "download" in transfer.kind:
                held = transfer.octets
            else:
                right |= transfer.kind == f"{way} upload" and transfer.octets == held
        yield f"SDO {way} upload of what was written", right
    yield "heartbeat each 20 ms", beats(frames, done)
    yield "RPDO, read by SDO", is_received(frames, done)
    sent = [frame.data for frame in frames if frame.id == 0x200 + NODE]
    shown = sent[-1][:1] + sent[-1][2:4] if sent else None
    is_sync = lambda frame: frame.id == 0x80
    is_answer = lambda frame: frame.id == 0x380 + NODE and frame.data == shown
    yield "SYNC, TPDO with what the RPDO said", follows(frames, is_sync, is_answer, is_sync)


def main():
    program, *master = sys.argv[1:]
    emulate = [program, "emulate", "-q", "--node", f"{NODE},eds={SHEET}", "--link", "slcan-tcp:127.0.0.1:0"]
    emulator = subprocess.Popen(emulate, stdout=subprocess.PIPE, text=True)
    try:
        ready = emulator.stdout.readline()
        place = ready.split(" ")[1].removeprefix("link=slcan-tcp:").strip()
        host, port = place.rsplit(":", 1)
        frames = []
        listen((host, int(port)), frames)
        ended = subprocess.run([*master, place, str(NODE), str(SHEET)], timeout=LIMIT).returncode
        time.sleep(0.2)
    finally:
        emulator.terminate()
        emulator.wait(10)
    failed = ended != 0
    if failed:
        print(f"FAIL the master ended with {ended}")
    for name, right in rows(frames):
        print("ok" if right else "FAIL", name)
        failed |= not right
    print(f"{len(frames)} frames were heard")
    sys.exit(failed)


if __name__ == "__main__":
    main()
