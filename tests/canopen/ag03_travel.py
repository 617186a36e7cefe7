"""Brings an emulated AG03/1 into OPERATION ENABLED and lets it travel: ag03_travel.py LINK EDS NODE.

LINK is the name in the ready line, `slcan-tcp:HOST:PORT`. The words are those of the manual's positioning mode.
"""

import sys
import time

import canopen

ENABLE = ((0x06, 0x0231), (0x07, 0x0233), (0x0F, 0x0337))
TARGET_REACHED = 0x0400


def main(link, eds, number):
    network = canopen.Network()
    channel = link.replace("slcan-tcp:", "socket://")
    network.connect(interface="slcan", channel=channel, bitrate=500000, sleep_after_open=0)
    try:
        node = network.add_node(canopen.RemoteNode(number, eds))
        node.nmt.state = "OPERATIONAL"
        time.sleep(0.1)
        for control, expected in ENABLE:
            node.sdo[0x6040].raw = control
            time.sleep(0.1)
            status = node.sdo[0x6041].raw
            assert status == expected, f"control word {control:04X}: status word {status:04X}, expected {expected:04X}"
        node.sdo[0x607A].raw = 800
        node.sdo[0x6040].raw = 0x1F
        end = time.monotonic() + 10
        while not (node.sdo[0x6041].raw & TARGET_REACHED and node.sdo[0x6064].raw == 800):
            assert time.monotonic() < end, f"after 10 s at {node.sdo[0x6064].raw}, expected 800"
            time.sleep(0.05)
    finally:
        network.disconnect()
    print("ok travel of the AG03/1 to 800")


main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
