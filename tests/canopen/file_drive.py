"""python-canopen's BaseNode402 moves drives that `profidrive emulate` has from their files, each axis of them.

    file_drive.py PROFIDRIVE FILE.eds|FOLDER...

Of a folder every file of CiA 402 with profile position is tried. Exit status 0 if each drive has moved.
"""

import contextlib
import pathlib
import subprocess
import sys
import time
import warnings

import canopen
from canopen.profiles.p402 import BaseNode402

NODE = 5
PATIENCE = 20.0
ACKNOWLEDGED, REACHED = 1 << 12, 1 << 10
NEEDED = (0x6040, 0x6041, 0x6060, 0x6061, 0x6064, 0x607A, 0x6081)


def wait(condition, what):
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"{what}: not within {PATIENCE} s")
        time.sleep(0.005)


def fits(sheet):
    """Whether python-canopen reads the file, and it is a drive with profile position."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            od = canopen.import_od(str(sheet), node_id=NODE)
        except Exception:  # noqa: BLE001 - what it cannot read it cannot drive
            return False
    if any(index not in od or not isinstance(od[index], canopen.objectdictionary.ODVariable) for index in NEEDED):
        return False
    device_type = od[0x1000].default if 0x1000 in od else None
    modes = od[0x6502].default if 0x6502 in od else None
    return (402 if device_type is None else device_type) & 0xFFFF == 402 and (modes or 1) & 1 == 1


def axes(od):
    """The objects of axis n + 1 are n times 800h behind those of the first."""
    behind = range(0, 8 * 0x800, 0x800)
    return [so_far for so_far in behind if all(index + so_far in od for index in NEEDED)]


def move(link, sheet):
    """Enables the drive, travels there and back; then its other axes."""
    network = canopen.Network()
    network.connect(interface="slcan", channel=link.replace("slcan-tcp:", "socket://"), sleep_after_open=0)
    try:
        node = BaseNode402(NODE, str(sheet))
        network.add_node(node)
        node.sdo.RESPONSE_TIMEOUT = 5.0
        node.setup_402_state_machine(read_pdos=False)
        node.nmt.state = "OPERATIONAL"
        behind = axes(node.object_dictionary)
        for axis in behind:
            move_axis(node, axis)
        return behind
    finally:
        network.disconnect()


def move_axis(node, behind):
    at = lambda index: node.sdo[index + behind]  # noqa: E731
    word = lambda value: setattr(at(0x6040), "raw", value)  # noqa: E731
    status = lambda: at(0x6041).raw  # noqa: E731
    at(0x6060).raw = 1
    for value, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        word(value)
        wait(lambda: status() & 0x6F == state, f"{0x6040 + behind:04X}h = {value:04X}h")
    # Ramps that bring it there soon, whatever the defaults are; some cannot be written.
    for index, value in ((0x6081, 10_000), (0x6083, 100_000), (0x6084, 100_000)):
        with contextlib.suppress(KeyError, canopen.SdoAbortedError):
            at(index).raw = value
    start = at(0x6064).raw
    for target in (start + 1000, start):
        at(0x607A).raw = target
        word(0x1F)
        wait(lambda: status() & ACKNOWLEDGED, "set-point acknowledged")
        word(0x0F)
        wait(lambda: status() & (ACKNOWLEDGED | REACHED) == REACHED, "target reached")
        position = at(0x6064).raw
        if abs(position - target) > 100:
            raise AssertionError(f"at {position} instead of {target}")
    word(0)


def play(program, sheet):
    command = [program, "emulate", "-q", "--node", f"{NODE},eds={sheet}", "--link", "slcan-tcp:127.0.0.1:0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        ready = process.stdout.readline().strip()
        if not ready.startswith("ready link="):
            raise RuntimeError("the emulator did not start")
        return len(move(ready.split(" ")[1].removeprefix("link="), sheet))
    finally:
        process.terminate()
        process.wait(10)


def main():
    program, *places = sys.argv[1:]
    files = []
    for place in map(pathlib.Path, places):
        files += sorted(file for file in place.iterdir() if fits(file)) if place.is_dir() else [place]
    failed = 0
    for sheet in files:
        try:
            axes = play(program, sheet)
            print(f"ok {sheet.name} has moved there and back" + (f", {axes} axes" if axes > 1 else ""))
        except Exception as error:  # noqa: BLE001 - each file is told
            failed += 1
            print(f"FAIL {sheet.name}: {error!r}")
    print(f"{len(files) - failed} of {len(files)} drives have moved")
    sys.exit(1 if failed or not files else 0)


if __name__ == "__main__":
    main()
