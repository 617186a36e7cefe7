"""Fixtures of pytest, there as soon as the package is installed.

`profibus_line` is an `Emulator` for one test, with one drive at address 5, or what the marker says:

    @pytest.mark.profibus(drives=[5, 6], stations=["7,gsd=io.gsd"])
    def test_start_up(profibus_line): ...

Everything on the line is captured. If the test fails, telegrams are explained in its report, and the capture
stays: the report names the file. Shown are those around the last thing that the log says of a station, and the last ones.
"""

import re
from bisect import bisect_right
from collections.abc import Generator, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import pytest

from ._binary import ProfidriveError
from ._decode import Telegram, decode_file
from ._emulator import Emulator

_TELEGRAMS_SHOWN: Final = 20
_LOG_SHOWN: Final = 20
_OF_STATION: Final = re.compile(r" (station|node) \d+\b")
_LINE: Final = pytest.StashKey[Emulator]()


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line(
        "markers", "profibus(drives, stations, line, ...): what is on profibus_line, the arguments of profidrive.Emulator"
    )


@pytest.fixture
def profibus_line(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Emulator]:
    """An emulator for this test. It ends with it."""
    marker = request.node.get_closest_marker("profibus")
    arguments = dict(marker.kwargs) if marker else {}
    if "line" not in arguments:
        arguments.setdefault("capture", tmp_path / "line.pcapng")
    with Emulator(*(marker.args if marker else ()), **arguments) as emulator:
        request.node.stash[_LINE] = emulator
        yield emulator


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    emulator = item.stash.get(_LINE, None)
    if report.failed and emulator is not None:
        report.sections.append((f"profibus line, {report.when}", _story(emulator)))
    return report


def _story(emulator: Emulator) -> str:
    """What happened on the line, for whoever looks for the reason of a failure."""
    log = list(emulator.log)[-_LOG_SHOWN:]
    lines = [f"log: {line}" for line in log]
    if emulator.capture is not None:
        try:
            telegrams = decode_file(emulator.capture)
        except (ProfidriveError, OSError) as error:
            nothing = "there are no octets" in str(error)
            lines.append("the master sent nothing" if nothing else f"the telegrams cannot be explained: {error}")
        else:
            lines += _around_the_last_event(log, telegrams)
            if not any(telegram.data.get("sender", "master") == "master" for telegram in telegrams):
                lines.append("the master sent nothing")
            lines.append(f"all {len(telegrams)} telegrams: {emulator.capture}")
    return "\n".join(lines)


def _around_the_last_event(log: list[str], telegrams: list[Telegram]) -> Iterator[str]:
    """The telegrams before and behind what was said last of a station or node, and the last ones, with their times."""
    half = _TELEGRAMS_SHOWN // 2
    times = [float(telegram.data.get("time", 0)) for telegram in telegrams]
    events = [time for line in log if _OF_STATION.search(line) and (time := _time_of(line)) is not None]
    middle = bisect_right(times, events[-1]) if events else len(times)
    shown = sorted({*range(max(0, middle - half), min(middle + half, len(times))), *range(max(0, len(times) - half), len(times))})
    for before, number in zip([-1, *shown], shown):
        if number > before + 1:
            yield f"({number - before - 1} telegrams)"
        yield f"{datetime.fromtimestamp(times[number], UTC):%H:%M:%S.%f} telegram: {telegrams[number]}"


def _time_of(line: str) -> float | None:
    """When the emulator wrote a line of its log."""
    try:
        return datetime.fromisoformat(line.split(" ", 1)[0]).timestamp()
    except ValueError:
        return None
