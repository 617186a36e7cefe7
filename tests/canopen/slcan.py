"""python-can at the slcan adapter of examples/can_node.rs: row L-07.

    slcan.py PROGRAM

Starts PROGRAM once with a pseudo-terminal and once with a TCP port, and uses both as a master would. Exit status 0 if
every step passed.
"""

import pathlib
import subprocess
import sys
import tempfile
import time

import can

PATIENCE = 5.0  # seconds


def expect(condition, what):
    if not condition:
        sys.exit(f"FAIL {what}")
    print(f"ok {what}")


def receive(bus, identifier):
    """The next frame with this identifier."""
    end = time.monotonic() + PATIENCE
    while (left := end - time.monotonic()) > 0:
        message = bus.recv(left)
        if message is not None and message.arbitration_id == identifier:
            return message
    sys.exit(f"FAIL no frame {identifier:03X}h within {PATIENCE} s")


def play(channel, other, **options):
    """One master, and if `other` says how, a second one."""
    with can.Bus(channel, interface="slcan", sleep_after_open=0, **options) as bus:
        beat = receive(bus, 0x705)
        expect(bytes(beat.data) == b"\x7f" and not beat.is_extended_id, "heartbeat")
        for number in range(20):
            data = bytes([0x40, 0x00, 0x10, number, 0, 0, 0, 0])
            bus.send(can.Message(arbitration_id=0x605, data=data, is_extended_id=False))
            answer = receive(bus, 0x585)
            expect(bytes(answer.data) == data, f"answer {number}")
        if other:
            with can.Bus(channel, interface="slcan", sleep_after_open=0) as second:
                receive(second, 0x705)
                bus.send(can.Message(arbitration_id=0x123, data=b"\x01\x02", is_extended_id=True))
                expect(bytes(receive(second, 0x123).data) == b"\x01\x02", "the other master hears 29 bits")
                second.send(can.Message(arbitration_id=0x124, is_remote_frame=True, dlc=3, is_extended_id=False))
                remote = receive(bus, 0x124)
                expect(remote.is_remote_frame and remote.dlc == 3, "and is heard: a remote request of length 3")
    # The terminal or the port is closed now. Whoever comes next gets fresh frames.
    time.sleep(0.3)
    with can.Bus(channel, interface="slcan", sleep_after_open=0, **options) as bus:
        end = time.monotonic() + 0.2
        count = 0
        while time.monotonic() < end:
            count += bus.recv(0.01) is not None
        expect(1 <= count <= 6, f"a heartbeat each 50 ms, {count} in 0.2 s: none is stale")


def started(program, link):
    process = subprocess.Popen([program, link], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    ready = process.stdout.readline().strip()
    if not ready.startswith("ready link="):
        sys.exit(f"FAIL {program} {link}: {ready!r}")
    return process, ready.removeprefix("ready link=")


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        for link, other in ((f"slcan-pty:{pathlib.Path(folder, 'can0')}", False), ("slcan-tcp:127.0.0.1:0", True)):
            process, name = started(program, link)
            try:
                print(f"== {name}")
                channel = name.replace("slcan-tcp:", "socket://")
                play(channel, other)
                play(channel, other, bitrate=500000)
            finally:
                process.terminate()
                process.wait()
    print("OK: python-can", can.__version__)


main()
