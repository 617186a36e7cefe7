"""A node of python-canopen or of durand behind the adapter of `profidrive judge --node`:

    judged_node.py canopen LINK NODE EDS     LocalNode with that data sheet
    judged_node.py durand LINK NODE EDS      a node whose own data sheet is written to EDS first

LINK is the terminal of the judge. Without LINK (-) durand only writes its data sheet. The program ends with the judge.
"""

import pathlib
import sys
import threading
import time

import can

KIND, LINK, NODE, EDS = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]


def python_canopen(bus):
    import canopen

    network = canopen.Network(bus)
    network.connect()
    network.add_node(canopen.LocalNode(NODE, EDS)).nmt.send_command(0)
    return network


class Nothing:
    """A network that goes nowhere: enough for a data sheet."""

    def add_subscription(self, cob_id, callback):
        pass

    def remove_subscription(self, cob_id):
        pass

    def send(self, cob_id, msg):
        pass


def durand_node(network):
    from durand import DatatypeEnum, MinimalNode, Variable

    node = MinimalNode(network, NODE)
    objects = node.object_dictionary
    for index, datatype, access, value in [
        (0x2000, DatatypeEnum.UNSIGNED16, "rw", 100),
        (0x2001, DatatypeEnum.INTEGER32, "rw", -5),
        (0x2002, DatatypeEnum.UNSIGNED32, "ro", 7),
        (0x2003, DatatypeEnum.VISIBLE_STRING, "ro", b"a text of its own"),
    ]:
        objects[index] = Variable(datatype, access, value, name=f"Object {index:X}h")
    return node


if LINK == "-":
    pathlib.Path(EDS).write_text(durand_node(Nothing()).eds.content)
    sys.exit(0)
bus = can.Bus(LINK, interface="slcan", bitrate=500_000, sleep_after_open=0)
if KIND == "canopen":
    kept = python_canopen(bus)
else:
    from durand import CANBusNetwork, set_scheduler
    from durand.scheduler import SyncScheduler

    scheduler = SyncScheduler()
    set_scheduler(scheduler)
    kept = durand_node(CANBusNetwork(bus))
    threading.Thread(target=scheduler.run, daemon=True).start()
while pathlib.Path(LINK).exists():
    time.sleep(0.1)
bus.shutdown()
