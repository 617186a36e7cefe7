#!/usr/bin/env python3
"""Have two readers of EDS files that know nothing of each other read the sheet of a device: python-canopen, and the
dcf-tools of Lely CANopen, which also check it by CiA 306.

    sheets.py PROFIDRIVE DEVICE

Both must find the same entries, with the same name, type, access, mapping and default value. Exit status 0, or 1 with lines
beginning with FAIL.
"""

import pathlib
import subprocess
import sys
import tempfile
import warnings

import canopen
from canopen.objectdictionary import ODVariable, datatypes
from dcf.device import Device
from dcf.lint import lint
from dcf.parse import parse_file

NODE = 5


def of_canopen(path):
    """Each entry as python-canopen reads it."""
    found = {}
    for index, entry in canopen.import_od(path, node_id=NODE).items():
        if index < 0x1000:
            continue  # made of [DummyUsage]
        entries = {0: entry} if isinstance(entry, ODVariable) else entry.subindices
        for sub, variable in entries.items():
            default = variable.default
            if variable.data_type in datatypes.INTEGER_TYPES and default is None:
                default = 0
            found[index, sub] = (variable.name, variable.data_type, variable.access_type, variable.pdo_mappable, default)
    return found


def of_dcf_tools(path):
    """Each entry as dcf-tools read it, and what they have to say about the file."""
    said = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sheet = parse_file(path)
        if not lint(sheet):
            said.append("lint refuses it")
        device = Device(sheet, {"NODEID": NODE})
    said += [str(warning.message) for warning in caught]
    found = {}
    for index, entry in device.items():
        if index < 0x1000:
            continue
        for sub, variable in entry.items():
            # A string is bare in CiA 306; dcf-tools wants quotes to make a value of it.
            is_text = variable.data_type.index == datatypes.VISIBLE_STRING
            value = sheet[f"{index:04X}"]["DefaultValue"] if is_text else variable.parse_value()
            mapping = bool(variable.pdo_mapping)
            found[index, sub] = (variable.name, int(variable.data_type.index), variable.access_type.name, mapping, value)
    return found, said


def main():
    program, device = sys.argv[1:]
    faults = []
    with tempfile.TemporaryDirectory() as folder:
        path = str(pathlib.Path(folder, f"{device}.eds"))
        sheet = subprocess.run([program, "eds", device], check=True, capture_output=True).stdout
        pathlib.Path(path).write_bytes(sheet)
        one = of_canopen(path)
        other, said = of_dcf_tools(path)
    faults += said
    for place in sorted(one.keys() | other.keys()):
        where = f"{place[0]:04X}h:{place[1]:02X}"
        if one.get(place) != other.get(place):
            faults.append(f"{where}: python-canopen {one.get(place)}, dcf-tools {other.get(place)}")
    for fault in faults:
        print(f"FAIL {device}: {fault}")
    if faults:
        sys.exit(1)
    print(f"{device}: {len(one)} entries, read alike by python-canopen and dcf-tools")


if __name__ == "__main__":
    main()
