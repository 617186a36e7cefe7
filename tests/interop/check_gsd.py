#!/usr/bin/env python3
"""Check what pyprofibus 1.13 makes of our GSD: the octets of Set_Prm and Chk_Cfg, ident number, rates.

Exit status 0, or 1 with one line per difference.
"""

import argparse
import sys

from pyprofibus.conf import PbConf
from pyprofibus.dp_master import DpSlaveDesc
from pyprofibus.gsd.interp import GsdInterp
from pyprofibus.gsd.parser import GsdError

IDENT_NUMBER = 0x0AC5
SUPPORTED = {
    "9.6": 60,
    "19.2": 60,
    "93.75": 60,
    "187.5": 60,
    "500": 100,
    "1.5M": 150,
    "3M": 250,
    "6M": 450,
    "12M": 800,
}
FIELDS = {
    "GSD_Revision": 3,
    "Station_Type": 0,
    "Protocol_Ident": 0,
    "45.45_supp": False,
    "Freeze_Mode_supp": True,
    "Sync_Mode_supp": True,
    "Auto_Baud_supp": True,
    "Set_Slave_Add_supp": False,
    "Fail_Safe": False,
    "DPV1_Slave": False,
    "Modular_Station": False,
    "Max_Input_Len": 14,
    "Max_Output_Len": 14,
    "Max_Data_Len": 28,
    "Max_Diag_Data_Len": 6,
    "User_Prm_Data_Len": 0,
    "Min_Slave_Intervall": 10,
    "Slave_Family": ["1"],
}


def telegrams(gsd):
    """Data of Set_Prm and Chk_Cfg as pyprofibus builds them for a slave at address 5."""
    conf = PbConf._SlaveConf()
    conf.gsd, conf.addr, conf.name, conf.index = gsd, 5, "AG03", 0
    conf.inputSize = conf.outputSize = 14
    conf.diagPeriod, conf.watchdogMs, conf.groupMask = 0, 1000, 1
    conf.syncMode = conf.freezeMode = True
    slave = conf.makeDpSlaveDesc()
    assert isinstance(slave, DpSlaveDesc)
    return bytes(slave.setPrmTelegram.getDU()).hex(" "), bytes(slave.chkCfgTelegram.getDU()).hex(" ")


def differences(path):
    gsd = GsdInterp.fromFile(path)

    def compare(name, got, expected):
        if got != expected:
            yield f"{name}: expected {expected!r}, got {got!r}"

    yield from compare("Ident_Number", gsd.getIdentNumber(), IDENT_NUMBER)
    for name, expected in FIELDS.items():
        yield from compare(name, gsd.getField(name), expected)
    for rate, max_tsdr in SUPPORTED.items():
        yield from compare(f"{rate}_supp", gsd.getField(f"{rate}_supp"), True)
        yield from compare(f"MaxTsdr_{rate}", gsd.getField(f"MaxTsdr_{rate}"), max_tsdr)

    set_prm, chk_cfg = telegrams(gsd)
    # lock, sync, freeze, watchdog 1 s = 100 * 1 * 10 ms, min T_SDR kept, ident, group 1; no user parameters
    yield from compare("Set_Prm", set_prm, "b8 64 01 00 0a c5 01")
    yield from compare("Chk_Cfg", chk_cfg, "f3 f2")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gsd", required=True)
    path = parser.parse_args().gsd
    try:
        found = list(differences(path))
    except GsdError as error:
        found = [" ".join(str(error).split())]
    for line in found:
        print(f"FAIL {path}: {line}", file=sys.stderr)
    if not found:
        print(f"OK {path}: pyprofibus reads ident 0AC5, Set_Prm of 7 octets, Chk_Cfg F3 F2")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
