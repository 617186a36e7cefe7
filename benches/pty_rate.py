#!/usr/bin/env python3
"""Exchanges per second of pyprofibus with station 5 at a terminal: `pty_rate.py TERMINAL SECONDS`."""

import pathlib
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "interop"))
from positioning import Drive  # noqa: E402


def main():
    terminal, seconds = sys.argv[1], float(sys.argv[2])
    drive = Drive(terminal, 500000, str(ROOT / "gsd" / "SIKO0AC5.GSD"), 5, 0)
    try:
        limit = time.monotonic() + 15
        while not drive.exchanges:
            drive.poll()
            if time.monotonic() > limit:
                sys.exit(f"no Data_Exchange within 15 s ({drive.trouble})")
        first, start = drive.exchanges, time.monotonic()
        while time.monotonic() - start < seconds:
            drive.poll()
        print((drive.exchanges - first) / (time.monotonic() - start))
    finally:
        drive.close()


main()
