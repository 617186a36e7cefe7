"""canopen-asyncio moves two AG03/1 at once by PDO, started by one SYNC: async_fleet.py LINK EDS NODE NODE.

LINK is the name in the ready line, `slcan-tcp:HOST:PORT`. Exit status 0 if every step passed.
"""

import asyncio
import sys

import canopen_asyncio as canopen
from canopen_asyncio.objectdictionary import eds

TARGETS = (700, -500)
PATIENCE = 15.0  # seconds
REACHED, ACKNOWLEDGE = 1 << 10, 1 << 12


def expect(condition, what):
    if not condition:
        sys.exit(f"FAIL {what}")
    print(f"ok {what}")


async def prepare(node, name):
    """Type 1 for RPDO 3 and TPDO 3: both follow SYNC. Another master may have left the node enabled."""
    node.nmt.send_command(0x80)
    vendor = await node.sdo[0x1018][1].aget_raw()
    expect(vendor == 0x195, f"{name}: vendor of SIKO")
    for pdo in (0x1402, 0x1802):
        await node.sdo[pdo][2].aset_raw(1)
    node.nmt.send_command(0x01)
    for word in (0x06, 0x07, 0x0F):
        await node.sdo[0x6040].aset_raw(word)
    status = await node.sdo[0x6041].aget_raw()
    expect(status & 0x6F == 0x27, f"{name}: operation enabled, {status:04X}h")
    try:
        await node.sdo[0x2410][5].aset_raw(0)
        sys.exit(f"FAIL {name}: v-Pos 0 was accepted")
    except canopen.SdoAbortedError as error:
        expect(error.code == 0x06090030, f"{name}: v-Pos 0 is refused")


def setpoint(network, number, word, target):
    network.send_message(0x400 + number, word.to_bytes(2, "little") + target.to_bytes(4, "little", signed=True))


class Seen:
    """The newest TPDO 3 of each node."""

    def __init__(self, network, numbers):
        self.newest = {}
        for number in numbers:
            network.subscribe(0x380 + number, self.hear)

    def hear(self, can_id, data, _timestamp):
        self.newest[can_id - 0x380] = (
            int.from_bytes(data[:2], "little"),
            int.from_bytes(data[2:6], "little", signed=True),
        )


async def sync_until(network, seen, what, done):
    end = asyncio.get_running_loop().time() + PATIENCE
    while not done():
        if asyncio.get_running_loop().time() > end:
            sys.exit(f"FAIL {what}: {seen.newest}")
        network.sync.transmit()
        await asyncio.sleep(0.01)
    print(f"ok {what}")


async def fleet(link, sheet, numbers):
    network = canopen.Network(loop=asyncio.get_running_loop())
    channel = link.replace("slcan-tcp:", "socket://")
    network.connect(interface="slcan", channel=channel, bitrate=500000, sleep_after_open=0)
    try:
        # By its path the package would look for the reader of python-canopen.
        nodes = [await network.aadd_node(number, eds.import_eds(sheet, number)) for number in numbers]
        await asyncio.gather(*(prepare(node, f"node {node.id}") for node in nodes))
        seen = Seen(network, numbers)
        before = [await node.sdo[0x6064].aget_raw() for node in nodes]
        for number, target in zip(numbers, TARGETS):
            setpoint(network, number, 0x1F, target)
        positions = [await node.sdo[0x6064].aget_raw() for node in nodes]
        expect(positions == before, "nobody starts before the SYNC")
        await sync_until(
            network, seen, "both acknowledge after the SYNC",
            lambda: len(seen.newest) == 2 and all(status & ACKNOWLEDGE for status, _ in seen.newest.values()),
        )
        for number, target in zip(numbers, TARGETS):
            setpoint(network, number, 0x0F, target)
        await sync_until(
            network, seen, "both reach their targets",
            lambda: all(
                seen.newest[number][0] & (REACHED | ACKNOWLEDGE) == REACHED
                and abs(seen.newest[number][1] - target) <= 10
                for number, target in zip(numbers, TARGETS)
            ),
        )
        for node in nodes:
            node.nmt.send_command(0x80)
    finally:
        network.disconnect()


asyncio.run(fleet(sys.argv[1], sys.argv[2], [int(number) for number in sys.argv[3:]]))
