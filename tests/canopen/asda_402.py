"""python-canopen's BaseNode402 drives the ASDA-A2 through PP, PV, HM and IP, unmodified.

    asda_402.py ASDA_A2_NODE            starts that program (examples/asda_a2_node.rs)
    asda_402.py --running LINK EDS ID   uses a drive that runs: `profidrive emulate --node 5,device=asda-a2 --link LINK`

LINK is slcan-tcp:HOST:PORT or a terminal. Exit status 0 if every step passed.
"""

import pathlib
import subprocess
import sys
import tempfile
import time

import canopen
from canopen.profiles.p402 import BaseNode402

NODE = 5
PATIENCE = 20.0  # seconds
REV = 1_280_000  # PUU per revolution
REACHED, ACKNOWLEDGE = 1 << 10, 1 << 12


def expect(condition, what):
    if not condition:
        sys.exit(f"FAIL {what}")
    print(f"ok {what}")


def wait(condition, what):
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"FAIL {what}: not within {PATIENCE} s")
        time.sleep(0.005)
    print(f"ok {what}")


def status(node):
    return node.sdo[0x6041].raw


def enable(node, mode):
    node.op_mode = mode
    node.state = "OPERATION ENABLED"
    expect(node.state == "OPERATION ENABLED" and node.op_mode == mode, f"{mode}: servo on")


def map_pdos(node):
    node.nmt.state = "PRE-OPERATIONAL"
    for number in range(1, 5):
        node.tpdo[number].read()
        node.rpdo[number].read()
    node.tpdo[1].clear()
    node.tpdo[1].add_variable(0x6041)
    node.tpdo[1].add_variable(0x6064)
    node.tpdo[1].trans_type = 255
    node.tpdo[1].event_timer = 20
    node.tpdo[1].enabled = True
    node.rpdo[1].clear()
    node.rpdo[1].add_variable(0x6040)
    node.rpdo[1].trans_type = 255
    node.rpdo[1].enabled = True
    # The positions of IP, taken at SYNC.
    node.rpdo[2].clear()
    node.rpdo[2].add_variable(0x60C1, 1)
    node.rpdo[2].trans_type = 1
    node.rpdo[2].enabled = True
    node.tpdo.save()
    node.rpdo.save()
    node.setup_402_state_machine(read_pdos=False)
    node.nmt.state = "OPERATIONAL"


def profile_position(node):
    enable(node, "PROFILED POSITION")
    node.sdo[0x6081].raw = 10 * REV
    for target, bits, expected in ((2 * REV, 0x10, 2 * REV), (-REV, 0x70, REV), (0, 0x30, 0)):
        node.sdo[0x607A].raw = target
        node.controlword = 0x0F
        node.controlword = 0x0F | bits
        wait(lambda: status(node) & ACKNOWLEDGE, "set-point acknowledged")
        node.controlword = 0x0F
        wait(lambda: status(node) & (REACHED | ACKNOWLEDGE) == REACHED, f"target {target} reached")
        expect(node.sdo[0x6064].raw == expected, f"position {expected}")


def profile_velocity(node):
    enable(node, "PROFILED VELOCITY")
    node.sdo[0x60FF].raw = 10_000
    wait(lambda: status(node) & REACHED, "1000 rpm reached")
    expect(abs(node.sdo[0x606C].raw - 10_000) <= 100, "actual velocity")
    node.sdo[0x60FF].raw = 0
    wait(lambda: status(node) & ACKNOWLEDGE, "zero speed")


def homing(node):
    node.sdo[0x607C].raw = 1234
    node.sdo[0x6099][1].raw = 2000
    node.sdo[0x6099][2].raw = 500
    for method in (35, 1, 2, 17, 33):
        node.sdo[0x6098].raw = method
        expect(node.homing(timeout=PATIENCE), f"homing, method {method}")
        expect(node.sdo[0x6064].raw == 1234, "home is 607Ch")


def stream(node, position, period):
    """Positions, each with a SYNC."""
    begin = time.monotonic()
    for cycle in range(150):
        node.rpdo[2][0].raw = position + 2_000 * cycle
        node.rpdo[2].transmit()
        node.network.sync.transmit()
        time.sleep(max(0.0, begin + (cycle + 1) * period - time.monotonic()))


def interpolated_position(node):
    period = 0.02
    node.sdo[0x60C2][1].raw = round(period * 1000)
    for _ in range(10):
        position = node.sdo[0x6064].raw
        enable(node, "INTERPOLATED POSITION")
        stream(node, position, period)
        # Once: without SYNC it does not stay so.
        active = status(node) & ACKNOWLEDGE
        if active:
            break
        # On a busy machine a SYNC may come two periods late: a fault, and the host begins anew.
        expect(node.sdo[0x603F].raw == 0x6200, "SYNC came late")
        node.reset_from_fault()
    target = node.rpdo[2][0]
    expect(active, "IP active")
    expect(abs(node.sdo[0x6062].raw - target.raw) < 20_000, "the demand is where the host is")
    wait(lambda: status(node) & 0x4F == 0x08, "fault after the last SYNC")
    expect(node.sdo[0x603F].raw == 0x6200, "SYNC time-out")
    node.reset_from_fault()
    expect(node.state == "OPERATION ENABLED", "fault reset, servo on again")


def drive(link, sheet, number):
    network = canopen.Network()
    if link.startswith("slcan-tcp:"):
        link = link.replace("slcan-tcp:", "socket://")
    network.connect(interface="slcan", channel=link, sleep_after_open=0)
    try:
        node = BaseNode402(number, sheet)
        network.add_node(node)
        node.sdo.RESPONSE_TIMEOUT = 2.0
        expect(node.sdo[0x1000].raw == 0x04020192, "device type")
        map_pdos(node)
        profile_position(node)
        profile_velocity(node)
        homing(node)
        interpolated_position(node)
    finally:
        network.disconnect()


def main():
    if sys.argv[1] == "--running":
        drive(sys.argv[2], sys.argv[3], int(sys.argv[4]))
    else:
        with tempfile.TemporaryDirectory() as folder:
            sheet = str(pathlib.Path(folder, "asda-a2.eds"))
            program = [sys.argv[1], "slcan-tcp:127.0.0.1:0", str(NODE), sheet]
            process = subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            try:
                ready = process.stdout.readline().strip()
                expect(ready.startswith("ready link="), ready)
                drive(ready.removeprefix("ready link="), sheet, NODE)
            finally:
                process.terminate()
                process.wait()
    print("OK: python-canopen", canopen.__version__)


main()
