"""Fixtures of pytest, there as soon as the package is installed.

`profibus_line` is an `Emulator` for one test, with one drive at address 5, or what the marker says:

    @pytest.mark.profibus(drives=[5, 6], stations=["7,gsd=io.gsd"])
    def test_start_up(profibus_line): ...

Everything on the line is captured. If the test fails, the last telegrams are explained in its report, and the capture
stays: the report names the file.
"""

from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Final

import pytest

from ._binary import ProfidriveError
from ._decode import decode_file
from ._emulator import Emulator

_TELEGRAMS_SHOWN: Final = 20
_LOG_SHOWN: Final = 20
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
    lines = [f"log: {line}" for line in emulator.log[-_LOG_SHOWN:]]
    if emulator.capture is not None:
        try:
            telegrams = decode_file(emulator.capture)
        except (ProfidriveError, OSError) as error:
            lines.append(f"the telegrams cannot be explained: {error}")
        else:
            lines += [f"telegram: {telegram}" for telegram in telegrams[-_TELEGRAMS_SHOWN:]]
            lines.append(f"all {len(telegrams)} telegrams: {emulator.capture}")
    return "\n".join(lines)
