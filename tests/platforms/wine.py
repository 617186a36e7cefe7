#!/usr/bin/env python3
"""The Windows build under Wine: demo, decode, an emulator with a master outside, the EEPROM after kills, the panel, Ctrl-C.

    tests/platforms/wine.py WINE PROFIDRIVE.EXE PROFIDRIVE

The last one is the command of this machine: the master outside. Exit status 0 if every step passed, 1 with a line that
begins with FAIL if one did not. WINEPREFIX says where Wine keeps its files.
"""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.request import ProxyHandler, Request, build_opener

WINE, EXE, NATIVE = sys.argv[1:]
LIMIT = 60
OPENER = build_opener(ProxyHandler({}))


def step(text):
    print(f"{time.monotonic() - BEGUN:5.1f} s  {text}", flush=True)


def check(holds, text):
    if not holds:
        sys.exit(f"FAIL {text}")


def run(*arguments, status=0, program=(WINE, EXE), stdin=""):
    outcome = subprocess.run([*program, *arguments], input=stdin, capture_output=True, text=True, timeout=LIMIT)
    said = outcome.stdout + outcome.stderr
    check(outcome.returncode == status, f"{arguments} ended with {outcome.returncode}, not {status}: {said}")
    return said


def master(link, *action, status=0, program=(NATIVE,)):
    return run("master", "--link", link, "--address", "5", *action, status=status, program=program)


class Emulator:
    """The Windows build, and what its ready line says."""

    def __init__(self, *arguments):
        command = [WINE, EXE, "emulate", "--link", "tcp:127.0.0.1:0", *arguments]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        check(line.startswith("ready "), f"no ready line but {line!r}")
        self.ready = dict(word.split("=", 1) for word in line.split()[1:])
        self.link, self.api = self.ready["link"], self.ready.get("panel", "") + "/api/v1"

    def http(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = Request(self.api + path, data, {"Content-Type": "application/json"}, method=method)
        with OPENER.open(request, timeout=20) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def end(self, how):
        self.process.send_signal(how)
        status = self.process.wait(LIMIT)
        self.process.stdout.close()
        return status


def windows(path):
    return "Z:" + str(path).replace("/", "\\")


BEGUN = time.monotonic()
folder = Path(tempfile.mkdtemp(prefix="profidrive-wine-"))

check(re.search(r"profidrive \d", run("--version")), "--version")
step("the first start")

demo = run("demo")
check("Data_Exchange" in demo or len(demo) > 500, f"demo: {demo}")
step("demo")

check("FDL status request" in run("decode", "10", "05", "02", "49", "50", "16"), "decode")
check("invalid" in run("decode", "10", "05", "02", "49", "51", "16", status=1), "decode of what is broken")
step("decode")

says = run("emulate", status=1)
check("pseudo-terminal" in says and "tcp:127.0.0.1" in says and "com0com" in says, f"pty: {says}")
says = run("emulate", "--link", "serial:COM77", "--baud", "19200", status=1)
check("cannot open serial device COM77" in says and "Device Manager" in says, f"serial: {says}")
step("what there is not says what there is instead")

state, capture = folder / "state", folder / "line.pcapng"
keeps = ("--state-dir", windows(state), "--panel", "127.0.0.1:0", "--capture", windows(capture))
emulator = Emulator(*keeps)
step(f"emulator at {emulator.link}")
check("5" in master(emulator.link, "scan"), "scan")
master(emulator.link, "write", "1004", "41")
check("41" in master(emulator.link, "read", "1004"), "what was written is read")
check("41" in master(emulator.link, "read", "1004", program=(WINE, EXE)), "read by the Windows build")
step("a master outside, and one of Windows")

drive = emulator.http("GET", "/drives/5")
check(drive["dp"]["ident_number"] == 0x0AC5, f"the panel: {drive}")
emulator.http("PATCH", "/drives/5/inputs", {"blocked": True})
check(emulator.http("GET", "/drives/5/inputs")["blocked"] is True, "an input set by HTTP")
emulator.http("PATCH", "/drives/5/inputs", {"blocked": False})
with OPENER.open(emulator.ready["panel"], timeout=20) as page:
    check(b"<html" in page.read().lower(), "the page")
step("panel by HTTP")

says = run("emulate", "--link", "tcp:127.0.0.1:0", *keeps[:2], status=1)
check("in use" in says or "another" in says, f"a state directory in use: {says}")
step("a state directory is for one process")

for round in range(3):
    master(emulator.link, "write", "1004", str(50 + round))
    end = time.monotonic() + 20
    while emulator.http("GET", "/drives/5")["eeprom"] != "stored":
        check(time.monotonic() < end, "the EEPROM is stored within 20 s")
        time.sleep(0.05)
    emulator.end(signal.SIGKILL)
    emulator = Emulator(*keeps)
    value = master(emulator.link, "read", "1004")
    check(str(50 + round) in value, f"after kill {round + 1}: {value}")
step("the EEPROM after three kills")

run("decode", "--brief", str(capture), program=(NATIVE,))
check(emulator.end(signal.SIGINT) == 0, "Ctrl-C ends the emulator with 0")
step("Ctrl-C")

print("OK")
