"""What HTTP does to emulated nodes, as python-canopen sees it: bench.py LINK PANEL EDS-AG03 EDS-AP10 EDS-ASDA.

LINK and PANEL are the names in the ready line of an emulator with the nodes 4 (AG03/1), 6 (AP10) and 7 (ASDA-A2). Each
fault is an EMCY with its code and error register, and an entry of 1003h.
"""

import json
import sys
import time
import urllib.request

import canopen

PATIENCE = 10
# Fault: code and error register. A, B and C of the AG03/1 need a shaft that is told to turn.
AG03 = {"D": (0x4310, 0x09), "E": (0x7300, 0x81), "F": (0xFF01, 0x81), "G": (0x3210, 0x05), "J": (0xFF09, 0x05)}
AP10 = {"battery-critical": (0xFF20, 0x81), "battery-empty": (0x3200, 0x81), "speed": (0xFF12, 0x81)}
ASDA = {"011": (0x7305, 0x21), "030": (0x7121, 0x21), "016": (0x4210, 0x09)}


def expect(condition, what):
    if not condition:
        sys.exit(f"FAIL {what}")
    print(f"ok {what}")


def http(method, path, body=None):
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"{panel}/api/v1/stations/{path}", data, {"content-type": "application/json"}, method=method)
    with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
        return json.load(answer)


def until(what, holds):
    end = time.monotonic() + PATIENCE
    while not holds():
        expect(time.monotonic() < end, what)
        time.sleep(0.02)
    expect(True, what)


def provoke(node, fault, code, register):
    node.emcy.reset()
    http("POST", f"{node.id}/provoke", {"fault": fault})
    until(f"node {node.id}, {fault}: EMCY {code:04X}h", lambda: any(emcy.code == code for emcy in node.emcy.log))
    emcy = next(emcy for emcy in node.emcy.log if emcy.code == code)
    expect(emcy.register == register, f"error register {emcy.register:02X}h, expected {register:02X}h")
    expect(node.sdo[0x1003][1].raw & 0xFFFF == code, "1003h has it")


def acknowledge(node):
    http("DELETE", f"{node.id}/inputs")
    for word in (0x00, 0x80, 0x00):
        node.sdo[0x6040].raw = word
    until(f"node {node.id}: reset", lambda: node.sdo[0x1001].raw == 0)


def main(link, eds):
    network = canopen.Network()
    network.connect(interface="slcan", channel=link.replace("slcan-tcp:", "socket://"), bitrate=500000, sleep_after_open=0)
    try:
        ag03, ap10, asda = (network.add_node(canopen.RemoteNode(number, sheet)) for number, sheet in zip((4, 6, 7), eds))
        for node in (ag03, ap10, asda):
            node.sdo.RESPONSE_TIMEOUT = 5.0
            node.nmt.state = "OPERATIONAL"
        for fault, (code, register) in AG03.items():
            provoke(ag03, fault, code, register)
            acknowledge(ag03)
        for fault, (code, register) in AP10.items():
            provoke(ap10, fault, code, register)
            http("DELETE", "6/inputs")
        http("PATCH", "6/inputs", {"shaft_revolutions": 1.5})
        expect(ap10.sdo[0x6004].raw == 1320, "6004h follows the shaft")
        for fault, (code, register) in ASDA.items():
            provoke(asda, fault, code, register)
            expect(asda.sdo[0x603F].raw == code, "603Fh has it")
            expect(http("GET", "7")["display"]["rows"][0]["text"] == f"AL{fault}", "the panel shows it")
            acknowledge(asda)

        # The keys turn the shaft in PRE-OPERATIONAL.
        ag03.nmt.state = "PRE-OPERATIONAL"
        before = ag03.sdo[0x6064].raw
        http("POST", "4/keys", {"key": "key_2", "pressed": True})
        until("key 2 turns the shaft", lambda: ag03.sdo[0x6064].raw != before)
        http("POST", "4/keys", {"key": "key_2", "pressed": False})

        for node in (ag03, ap10, asda):
            http("PUT", f"{node.id}/power", {"on": False})
            try:
                node.sdo.RESPONSE_TIMEOUT = 0.3
                node.sdo[0x1000].raw
                sys.exit(f"FAIL node {node.id} answers without supply")
            except canopen.SdoCommunicationError:
                node.sdo.RESPONSE_TIMEOUT = 5.0
            heard = []
            network.subscribe(0x700 + node.id, lambda _id, data, _time: heard.append(bytes(data)))
            http("PUT", f"{node.id}/power", {"on": True})
            until(f"node {node.id} boots", lambda: b"\0" in heard)
            expect(node.sdo[0x1001].raw == 0, f"node {node.id}: boot-up after power-on, nothing is wrong")
    finally:
        network.disconnect()
    print("OK: nodes on a bench, with python-canopen", canopen.__version__)


panel = sys.argv[2]
main(sys.argv[1], sys.argv[3:])
