#!/usr/bin/env python3
"""A tank behind an emulated station: a valve fills it, a pump empties it, two switches and a level sensor watch it.

    profidrive emulate --panel 127.0.0.1:8080 --station 7,gsd=tests/gsd/remote_io.gsd
    examples/tank.py http://127.0.0.1:8080 7

The PLC has the modules 8 DI, 8 DO and 2 AI in slots 1 to 3:
    8 DO  bit 0 valve, bit 1 pump        8 DI  bit 0 tank full, bit 1 tank empty
    2 AI  the level as a word, 0 to 27648 for 0 to 100 percent
"""

import json
import sys
import time
import urllib.error
import urllib.request

CYCLE = 0.05  # seconds
FILL, DRAIN = 20.0, 30.0  # percent per second
FULL_SCALE = 27648


class Station:
    """Inputs and outputs of a station over HTTP, by slot, octet and type."""

    def __init__(self, panel, address):
        self.root = f"{panel.rstrip('/')}/api/v1/stations/{address}"

    def ask(self, method, place, body=None):
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"}
        request = urllib.request.Request(f"{self.root}/{place}", data, headers, method=method)
        with urllib.request.urlopen(request, timeout=5) as response:
            return json.load(response)

    def output(self, place):
        return self.ask("GET", f"outputs/{place}")["value"]

    def set_input(self, place, value):
        self.ask("PUT", f"inputs/{place}", {"value": value})


def main():
    station = Station(sys.argv[1], sys.argv[2])
    level = 0.0
    while True:
        try:
            valve, pump = station.output("2/0/bit0"), station.output("2/0/bit1")
            level += (FILL * valve - DRAIN * pump) * CYCLE
            level = min(max(level, 0.0), 100.0)
            station.set_input("3/0/unsigned16", round(level / 100 * FULL_SCALE))
            station.set_input("1/0/bit0", int(level >= 95))
            station.set_input("1/0/bit1", int(level <= 5))
        except urllib.error.HTTPError as error:
            # No master has configured these modules yet.
            print(json.load(error)["detail"], flush=True)
        time.sleep(CYCLE)


if __name__ == "__main__":
    main()
