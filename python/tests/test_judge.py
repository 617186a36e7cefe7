import subprocess
import sys
from pathlib import Path

import pytest

from profidrive import Emulator, Judge, ProfidriveError

MASTER = Path(__file__).parents[2] / "examples" / "python" / "judged_master.py"
STATION = "5,ident=1234,cfg=2313,groups=01"


@pytest.mark.skipif(sys.platform == "win32", reason="the master of the example wants a pseudo-terminal")
def test_a_master_is_judged_row_by_row_and_its_capture_again(tmp_path: Path) -> None:
    capture = tmp_path / "line.pcapng"
    with Judge([STATION], only=["M-P05", "M-U01"], options=["--master", "2", "--capture", str(capture)]) as judge:
        with subprocess.Popen([sys.executable, str(MASTER), judge.link, "5"]) as master:
            try:
                report = judge.report(timeout=120)
            finally:
                master.kill()
    assert report.passed and not report.failed
    assert (report.ended, report.status) == ("everything was tried", 0)
    assert [row.id for row in report.rows] == ["M-U01", "M-P05"]
    assert report["M-P05"].verdict == "pass"
    with pytest.raises(KeyError):
        assert report["M-F01"]
    assert Judge.of_capture(capture, "--station", STATION, "--only", "M-P05")["M-P05"].verdict == "pass"


@pytest.mark.skipif(sys.platform == "win32", reason="the master of the example wants a pseudo-terminal")
def test_no_failed_row_is_no_pass() -> None:
    # A row of a ring: this master passes no token.
    with Judge([STATION], only=["M-K02"]) as judge:
        with subprocess.Popen([sys.executable, str(MASTER), judge.link, "5"]) as master:
            try:
                report = judge.report(timeout=120)
            finally:
                master.kill()
    assert not report.failed
    assert not report.passed
    assert report.status == 4


def test_the_judge_says_that_no_master_came() -> None:
    with Judge([STATION], link="tcp:127.0.0.1:0") as judge:
        assert judge.link.startswith("tcp:")
        with pytest.raises(ProfidriveError, match="no master was heard"):
            judge.report(timeout=60)


def test_a_capture_without_a_master_is_no_report(tmp_path: Path) -> None:
    with Emulator(capture=tmp_path / "line.pcapng"):
        pass
    with pytest.raises(ProfidriveError):
        Judge.of_capture(tmp_path / "line.pcapng")
