#!/usr/bin/env python3
"""Check what python-canopen makes of an EDS: every entry, its type, name, mapping and default at node 5.

    check_eds.py FILE.eds TABLE.tsv

TABLE has a line per entry: index, sub-index (hexadecimal), type number, name, 1 if mappable, default.
Exit status 0, or 1 with one line per difference.
"""

import sys

import canopen
from canopen.objectdictionary import datatypes

NODE = 5


def main():
    eds, table = sys.argv[1:]
    dictionary = canopen.import_od(eds, node_id=NODE)
    faults = []
    expected = {}
    with open(table, encoding="utf-8") as lines:
        for line in lines:
            index, sub, code, name, mapped, default = line.rstrip("\n").split("\t")
            expected[int(index, 16), int(sub, 16)] = (int(code), name, mapped == "1", default)
    found = {}
    for index, entry in dictionary.items():
        if index < 0x1000:
            continue  # made of [DummyUsage]
        if isinstance(entry, canopen.objectdictionary.ODVariable):
            found[index, 0] = entry
        else:
            for sub, variable in entry.subindices.items():
                found[index, sub] = variable
    for place in sorted(expected.keys() | found.keys()):
        where = f"{place[0]:04X}h:{place[1]:02X}"
        if place not in found or place not in expected:
            faults.append(f"{where} is only in the {'table' if place in expected else 'EDS'}")
            continue
        code, name, mapped, default = expected[place]
        variable = found[place]
        if variable.data_type != code:
            faults.append(f"{where}: type {variable.data_type}, expected {code}")
        if variable.name != name:
            faults.append(f"{where}: name {variable.name!r}, expected {name!r}")
        if variable.pdo_mappable != mapped:
            faults.append(f"{where}: mappable {variable.pdo_mappable}, expected {mapped}")
        value = variable.default
        if code in datatypes.INTEGER_TYPES and default and value != int(default):
            faults.append(f"{where}: default {value}, expected {default}")
        if code == datatypes.VISIBLE_STRING and (value or "") != default:
            faults.append(f"{where}: default {value!r}, expected {default!r}")
    node = canopen.RemoteNode(NODE, dictionary)
    pdos = len(node.rpdo.map), len(node.tpdo.map)
    if pdos != (4, 4):
        faults.append(f"{pdos} PDOs, expected (4, 4)")
    for fault in faults:
        print(f"FAIL {fault}")
    if faults:
        sys.exit(1)
    print(f"OK: {len(expected)} entries, {pdos[0]} RPDOs, {pdos[1]} TPDOs")


if __name__ == "__main__":
    main()
