"""Emulated drives on PROFIBUS-DP and CANopen, to test masters against: the command `profidrive`, from Python.

| name | is |
| --- | --- |
| `Emulator` | one run of `profidrive emulate`: drives and stations on a line |
| `Drive` | a drive, a node or another station on the line, seen and changed without the bus; `Station` is the same |
| `Judge` | one run of `profidrive judge`: a master under test, row by row |
| `decode` | telegrams explained |
"""

from ._api import ApiError
from ._binary import ProfidriveError, binary
from ._decode import Field, Telegram, decode, decode_file
from ._drive import Drive, Station, Word
from ._emulator import Emulator, Line
from ._events import Event, Events, Kind
from ._faults import LineFault
from ._judge import Judge, Report, Row

__all__ = [
    "ApiError",
    "Drive",
    "Emulator",
    "Event",
    "Events",
    "Field",
    "Judge",
    "Kind",
    "Line",
    "LineFault",
    "ProfidriveError",
    "Report",
    "Row",
    "Station",
    "Telegram",
    "Word",
    "binary",
    "decode",
    "decode_file",
]
