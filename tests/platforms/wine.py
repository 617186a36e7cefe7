#!/usr/bin/env python3
"""The Windows build under Wine: what the table of docs/platforms.md says about Windows, as far as Wine goes.

    tests/platforms/wine.py WINE PROFIDRIVE.EXE PROFIDRIVE

The last one is the command of this machine: the master, or the emulator, at the other end of the line. Exit status 0 if every
step passed, 1 with a line that begins with FAIL if one did not. WINEPREFIX says where Wine keeps its files.
"""

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tty
from pathlib import Path
from urllib.request import ProxyHandler, Request, build_opener

WINE, EXE, NATIVE = sys.argv[1:]
WINDOWS = (WINE, EXE)
LIMIT = 60
OPENER = build_opener(ProxyHandler({}))
GSD = Path(__file__).resolve().parents[2] / "gsd" / "SIKO0AC5.GSD"
# What Wine takes for COM1: a link to the terminal that a step wants there.
COM1 = Path(os.environ["WINEPREFIX"]) / "com1"


def step(text):
    print(f"{time.monotonic() - BEGUN:5.1f} s  {text}", flush=True)


def check(holds, text):
    if not holds:
        sys.exit(f"FAIL {text}")


def within(seconds, holds, text):
    end = time.monotonic() + seconds
    while not holds():
        check(time.monotonic() < end, f"not within {seconds} s: {text}")
        time.sleep(0.05)


def run(*arguments, status=0, program=WINDOWS, stdin=""):
    outcome = subprocess.run([*program, *arguments], input=stdin, capture_output=True, text=True, timeout=LIMIT)
    said = outcome.stdout + outcome.stderr
    check(outcome.returncode == status, f"{arguments} ended with {outcome.returncode}, not {status}: {said}")
    return said


def master(link, *action, program=(NATIVE,), by=("--address", "5"), **more):
    return run("master", "--link", link, *by, *action, program=program, **more)


class Process:
    """A command that goes on until it is told to end; what its ready line says, if it has one."""

    def __init__(self, *arguments, program=WINDOWS, is_ready=True):
        self.log = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(
            [*program, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=self.log, text=True
        )
        if not is_ready:
            return
        line = self.process.stdout.readline()
        check(line.startswith("ready "), f"{arguments}: no ready line but {line!r} {self.said()}")
        self.ready = dict(word.split("=", 1) for word in line.split()[1:])
        self.link, self.api = self.ready["link"], self.ready.get("panel", "") + "/api/v1"

    def http(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = Request(self.api + path, data, {"Content-Type": "application/json"}, method=method)
        with OPENER.open(request, timeout=20) as answer:
            text = answer.read()
        return json.loads(text) if text else None

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def end(self, how):
        self.process.send_signal(how)
        status = self.process.wait(LIMIT)
        self.process.stdout.close()
        return status


def emulator(*arguments, link="tcp:127.0.0.1:0", program=WINDOWS):
    return Process("emulate", "--link", link, *arguments, program=program)


def windows(path):
    return "Z:" + str(path).replace("/", "\\")


def com1(terminal):
    COM1.unlink(missing_ok=True)
    COM1.symlink_to(terminal)


def two_terminals():
    """A cable: what is written to one terminal is read from the other."""
    ends = [pty.openpty() for _ in range(2)]
    for _, slave in ends:
        tty.setraw(slave)
    other = {ends[0][0]: ends[1][0], ends[1][0]: ends[0][0]}

    def carry():
        while True:
            for end in select.select(list(other), [], [])[0]:
                os.write(other[end], os.read(end, 512))

    threading.Thread(target=carry, daemon=True).start()
    return [os.ttyname(slave) for _, slave in ends]


BEGUN = time.monotonic()
folder = Path(tempfile.mkdtemp(prefix="profidrive-wine-"))

check(re.search(r"profidrive \d", run("--version")), "--version")
check("Data_Exchange" in run("demo"), "demo")
step("demo")

check("FDL status request" in run("decode", "10", "05", "02", "49", "50", "16"), "decode")
check("invalid" in run("decode", "10", "05", "02", "49", "51", "16", status=1), "decode of what is broken")
check("33F8" in run("encode", "pkw", "write", "limit1", "250000"), "encode")
check("0AC5" in run("gsd", windows(GSD)) and "[DeviceInfo]" in run("eds", "ap10"), "gsd, eds")
step("decode, encode, gsd, eds")

says = run("emulate", status=1)
check("pseudo-terminal" in says and "tcp:127.0.0.1" in says and "com0com" in says, f"pty: {says}")
says = run("emulate", "--link", "serial:COM77", "--baud", "19200", status=1)
check("cannot open serial device COM77" in says and "Device Manager" in says, f"serial: {says}")
for link in ("COM1", "/dev/pts/3"):
    says = run("master", "--link", link, "--address", "5", "status", status=2)
    check("serial:COM3" in says, f"no link of Windows: {says}")
step("what there is not says what there is instead")

state, capture = folder / "state", folder / "line.pcapng"
keeps = ("--state-dir", windows(state), "--panel", "127.0.0.1:0", "--metrics", "127.0.0.1:0", "--capture", windows(capture))
emulated = emulator(*keeps)
master(emulated.link, "write", "1004", "41")
check("41" in master(emulated.link, "read", "1004"), "what was written is read")
step("a master outside, on TCP")

check(emulated.http("GET", "/stations/5")["device"] == "ag03-1", "the panel")
emulated.http("PATCH", "/stations/5/inputs", {"blocked": True})
check(emulated.http("GET", "/stations/5/inputs")["blocked"] is True, "an input set by HTTP")
emulated.http("PATCH", "/stations/5/inputs", {"blocked": False})
with OPENER.open(emulated.ready["panel"], timeout=20) as page:
    check(b"<html" in page.read().lower(), "the page")
with OPENER.open(emulated.ready["metrics"], timeout=20) as metrics:
    check(metrics.read().rstrip().endswith(b"# EOF"), "the metrics")
step("panel and metrics by HTTP")

says = run("emulate", "--link", "tcp:127.0.0.1:0", *keeps[:2], status=1)
check("in use" in says or "another" in says, f"a state directory in use: {says}")
for value in ("50", "51", "52"):
    master(emulated.link, "write", "1004", value)
    within(20, lambda: emulated.http("GET", "/stations/5")["eeprom"] == "in its file", "the EEPROM is stored")
    emulated.end(signal.SIGKILL)
    emulated = emulator(*keeps)
    says = master(emulated.link, "read", "1004")
    check(value in says, f"after the kill: {says}")
step("a state directory: for one process, and kept through three kills")

check(emulated.end(signal.SIGINT) == 0, f"Ctrl-C ends the emulator with 0: {emulated.said()}")
check("ended" in emulated.said(), f"what the emulator says at its end: {emulated.said()}")
for program, path in ((WINDOWS, windows(capture)), ((NATIVE,), str(capture))):
    says = run("decode", "--brief", path, program=program)
    check("1004" in says, f"the capture, explained: {says}")
check(" 0 failed" in run("judge", "--only", "M-F*", windows(capture)), "the capture, judged")
step("Ctrl-C; a capture explained and judged")

verdicts = folder / "verdicts.json"
judge = Process(
    *("judge", "--link", "tcp:127.0.0.1:0", "--station", "5,ident=0AC5,cfg=F3F2", "--master", "0"),
    *("--only", "M-F02,M-F05,M-U01,M-P05", "--json", windows(verdicts)),
)
# The judge plays a station that takes no PKW job: the master gives up after its exchanges.
master(judge.link, "monitor", status=1)
# Interrupted: not finished.
check(judge.end(signal.SIGINT) == 4, f"judge: {judge.said()}")
rows = {row["id"]: row["verdict"] for row in json.loads(verdicts.read_text())["rows"]}
check(rows == dict.fromkeys(("M-F02", "M-F05", "M-U01", "M-P05"), "pass"), f"judge: {rows}")
step("a master outside, judged")

for name in ("tcp", "COM1"):
    native = emulator(
        *("--panel", "127.0.0.1:0"), link="tcp:127.0.0.1:0" if name == "tcp" else "pty", program=(NATIVE,)
    )
    link, rate = native.link, ()
    if name == "COM1":
        com1(native.link)
        link, rate = "serial:COM1", ("--baud", "19200")
    check("1004" in master(link, "read", "1004", *rate, program=WINDOWS), f"read on {name}")
    for _ in range(2):
        master(link, "save", windows(folder / "axis.json"), *rate, program=WINDOWS)
    check("v-Pos" in (folder / "axis.json").read_text(), "a file is written, and replaced")
    moves = Process("master", "--link", link, "--address", "5", *rate, "move", "100000", "--yes", is_ready=False)
    speed = lambda: next(value["value"] for value in native.http("GET", "/stations/5")["values"] if value["key"] == "speed")
    within(20, lambda: speed() != 0, "the drive turns")
    check(moves.end(signal.SIGINT) != 0, "a move that was stopped is no success")
    check(speed() == 0, f"Ctrl-C stops the drive on {name}: {moves.said()}")
    native.end(signal.SIGINT)
    step(f"master on {name}; Ctrl-C stops the drive")

ours, theirs = two_terminals()
com1(ours)
emulated = emulator("--baud", "19200", link="serial:COM1")
check("1004" in master(theirs, "read", "1004"), "a drive on COM1")
check(emulated.end(signal.SIGINT) == 0, "Ctrl-C ends an emulator on COM1 with 0")
step("a drive on COM1")

for place, far in (("slcan-tcp:127.0.0.1:0", None), ("slcan-tty:COM1", f"slcan-tty:{theirs}")):
    node = Process("emulate", "--node", "5", "--link", place)
    says = master(far or node.link, "read", "6041", by=("--node", "5"))
    check("statusword" in says.lower(), f"a node on {place}: {says}")
    check(node.end(signal.SIGINT) == 0, f"Ctrl-C ends a node on {place} with 0")
step("CANopen over slcan, on TCP and COM1")

print("OK")
