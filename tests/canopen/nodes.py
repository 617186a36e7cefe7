"""python-canopen at `profidrive emulate --node`: boot-up, heartbeat, and every entry of the EDS by SDO.

    nodes.py PROFIDRIVE DEVICE|FILE.eds|FILE.dcf

Starts the node behind a TCP port and behind a pseudo-terminal. Exit status 0 if every step passed.
"""

import pathlib
import subprocess
import sys
import tempfile

import canopen

NODE = 5
# A domain of tests/eds/pump.eds.
PROGRAM = 0x2005
READABLE = {"ro", "rw", "rwr", "rww", "const"}
# 06060000h and 08000000h ff. are answers of a device that has the entry; these say that it is not there or not readable.
NOT_THERE = {0x06020000, 0x06090011, 0x06010001}


def expect(condition, what):
    if not condition:
        sys.exit(f"FAIL {what}")
    print(f"ok {what}")


def entries(dictionary):
    for index, entry in dictionary.items():
        if index < 0x1000:
            continue  # made of [DummyUsage]
        if isinstance(entry, canopen.objectdictionary.ODVariable):
            yield entry
        else:
            yield from entry.subindices.values()


def read_all(node):
    read = refused = 0
    for entry in entries(node.object_dictionary):
        where = f"{entry.index:04X}h:{entry.subindex:02X} {entry.name}"
        if entry.access_type not in READABLE:
            continue
        try:
            octets = node.sdo.upload(entry.index, entry.subindex)
        except canopen.SdoAbortedError as error:
            if error.code in NOT_THERE:
                sys.exit(f"FAIL {where} is in the EDS and is answered with {error}")
            refused += 1
            continue
        if entry.data_type in canopen.objectdictionary.datatypes.INTEGER_TYPES and len(octets) * 8 != len(entry):
            sys.exit(f"FAIL {where}: {len(octets)} octets, the EDS says {len(entry)} bits")
        read += 1
    expect(read >= 5 and refused * 4 < read, f"{read} entries read, {refused} refused by the device")


def blocks(node):
    """A domain in blocks and in segments, each way."""
    value = bytes(number * 7 % 251 for number in range(3000))
    for as_block in (True, False):
        with node.sdo[PROGRAM].open("wb", size=len(value), block_transfer=as_block) as domain:
            domain.write(value)
        for read_as_block in (True, False):
            with node.sdo[PROGRAM].open("rb", block_transfer=read_as_block) as domain:
                expect(domain.read() == value, f"a domain, in blocks: written {as_block}, read {read_as_block}")


def boot(network, node):
    """Resets the node and waits for its boot-up. It may come before python-canopen begins to wait: then once more."""
    for last in (False, False, False, True):
        network.nmt.send_command(0x81)
        try:
            node.nmt.wait_for_bootup(2)
        except canopen.nmt.NmtError:
            if last:
                raise
        else:
            return


def play(link, sheet):
    network = canopen.Network()
    network.connect(interface="slcan", channel=link.replace("slcan-tcp:", "socket://"), sleep_after_open=0)
    try:
        node = network.add_node(canopen.RemoteNode(NODE, sheet))
        node.sdo.RESPONSE_TIMEOUT = 5.0
        boot(network, node)
        expect(True, "boot-up after reset node")
        expect(node.sdo[0x1018][1].raw == node.object_dictionary.device_information.vendor_number, "vendor")
        read_all(node)
        program = node.object_dictionary.get(PROGRAM)
        if getattr(program, "data_type", None) == canopen.objectdictionary.datatypes.DOMAIN:
            blocks(node)
        node.sdo[0x1017].raw = 50
        node.nmt.state = "OPERATIONAL"
        for _ in range(3):
            state = node.nmt.wait_for_heartbeat(5)
        expect(state == "OPERATIONAL", "heartbeat says OPERATIONAL")
    finally:
        network.disconnect()


def main():
    program, device = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        sheet = pathlib.Path(device)
        spec = f"eds={device}"
        if not sheet.suffix:
            sheet = pathlib.Path(folder, f"{device}.eds")
            sheet.write_bytes(subprocess.run([program, "eds", device], check=True, capture_output=True).stdout)
            spec = f"device={device}"
        for link in ("slcan-tcp:127.0.0.1:0", f"slcan-pty:{pathlib.Path(folder, 'can0')}"):
            command = [program, "emulate", "-q", "--node", f"{NODE},{spec}", "--link", link]
            process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
            try:
                ready = process.stdout.readline().strip()
                expect(ready.startswith("ready link=") and ready.endswith(f" nodes={NODE}"), ready)
                play(ready.split(" ")[1].removeprefix("link="), str(sheet))
            finally:
                process.terminate()
                expect(process.wait(10) == 0, "ended by SIGTERM with 0")
    print(f"OK: {device} with python-canopen", canopen.__version__)


main()
