"""python-canopen does every service that any_master.py listens for: python_master.py HOST:PORT NODE EDS"""

import sys
import time

import canopen

place, node, sheet = sys.argv[1], int(sys.argv[2]), sys.argv[3]
VALUE = bytes(number * 7 % 251 for number in range(1000))


def expect(condition, what):
    if not condition:
        sys.exit(f"FAIL python-canopen: {what}")


network = canopen.Network()
network.connect(interface="slcan", channel=f"socket://{place}", sleep_after_open=0)
node = network.add_node(canopen.RemoteNode(node, sheet))
node.sdo.RESPONSE_TIMEOUT = 5.0
node.nmt.send_command(0x81)
time.sleep(0.3)
expect(node.sdo[0x1018][1].raw == 0x195, "1018h:01")
node.sdo[0x1017].raw = 20
for as_block in (False, True):
    with node.sdo[0x2000].open("wb", size=len(VALUE), block_transfer=as_block) as domain:
        domain.write(VALUE)
    with node.sdo[0x2000].open("rb", block_transfer=as_block) as domain:
        expect(domain.read() == VALUE, f"2000h, in blocks: {as_block}")
node.nmt.state = "OPERATIONAL"
network.send_message(0x200 + node.id, b"\x81\0\x39\x05")
expect(node.sdo[0x6411][1].raw == 1337, "6411h:01")
for _ in range(3):
    network.sync.transmit()
    time.sleep(0.02)
time.sleep(0.5)
network.disconnect()
