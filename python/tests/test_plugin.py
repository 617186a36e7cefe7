import os
import re
import socket
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from profidrive import Emulator

pytest_plugins = ["pytester"]


@pytest.mark.profibus(drives=[5, 6])
def test_the_marker_says_what_is_on_the_line(profibus_line: Emulator) -> None:
    assert list(profibus_line.drives) == [5, 6]


FAILS = """
    import socket
    import pytest

    @pytest.mark.profibus(drives=[5], link="tcp:127.0.0.1:0")
    def test_of_a_master(profibus_line):
        host, port = profibus_line.link.removeprefix("tcp:").rsplit(":", 1)
        with socket.create_connection((host, int(port)), timeout=10) as line:
            line.sendall(bytes.fromhex("10 05 02 49 50 16"))
            assert len(line.recv(6)) == 6
        assert profibus_line.drives[5].dp_state == "DATA-EXCH"
"""


def test_a_failed_test_shows_the_last_telegrams_and_leaves_the_capture(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(FAILS)
    result = pytester.runpytest_subprocess()
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*profibus line, call*", "*telegram: 2 -> 5*FDL status request*", "*all 2 telegrams: *"])
    (last,) = [line for line in result.stdout.lines if line.startswith("all 2 telegrams: ")]
    assert Path(last.removeprefix("all 2 telegrams: ")).stat().st_size > 0


SILENT = """
    def test_of_a_master(profibus_line):
        assert profibus_line.drives[5].dp_state == "DATA-EXCH"
"""


def test_a_failed_test_says_that_the_master_sent_nothing(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(SILENT)
    result = pytester.runpytest_subprocess()
    result.assert_outcomes(failed=1)
    assert "the master sent nothing" in result.stdout.lines


REFUSED = """
    import socket
    import time

    import pytest

    @pytest.mark.profibus(drives=[5], link="tcp:127.0.0.1:0")
    def test_of_a_master(profibus_line):
        host, port = profibus_line.link.removeprefix("tcp:").rsplit(":", 1)
        with socket.create_connection((host, int(port))) as line:
            def ask(request, reply):
                line.sendall(bytes.fromhex(request))
                while reply:
                    reply -= len(line.recv(reply))
            for _ in range(50):
                ask("10 05 02 49 50 16", 6)
            # Set_Prm of another device.
            ask("68 0C 0C 68 85 82 6D 3D 3E 80 01 01 0B 12 34 00 C2 16", 1)
            while not any("ident number 0x1234" in line for line in profibus_line.log):
                time.sleep(0.01)
            for _ in range(50):
                ask("10 05 02 49 50 16", 6)
        assert profibus_line.drives[5].dp_state == "DATA-EXCH"
"""


def test_a_failed_test_shows_the_telegrams_around_the_last_event(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(REFUSED)
    result = pytester.runpytest_subprocess()
    result.assert_outcomes(failed=1)
    shown = [line for line in result.stdout.lines if " telegram: " in line]
    # 10 before what was refused, 10 behind it, and the last 10.
    assert [number for number, line in enumerate(shown) if "short acknowledge: Set_Prm received" in line] == [9], shown
    assert len(shown) == 30 and all(re.match(r"\d\d:\d\d:\d\d\.\d{6} ", line) for line in shown), shown
    assert "(92 telegrams)" in result.stdout.lines and "(80 telegrams)" in result.stdout.lines


KILLED = """
    import time

    def test_of_a_master(profibus_line):
        print(f"\\nemulator={profibus_line._process.pid}", flush=True)
        time.sleep(60)
"""


def test_the_emulator_ends_with_a_pytest_that_is_killed(tmp_path: Path) -> None:
    (tmp_path / "test_killed.py").write_text(textwrap.dedent(KILLED))
    command = [sys.executable, "-m", "pytest", "-s", "-q", "test_killed.py"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as tests:
        assert tests.stdout is not None
        emulator = next(int(line.partition("=")[2]) for line in tests.stdout if line.startswith("emulator="))
        assert is_running(emulator)
        tests.kill()
    end = time.monotonic() + 10
    while is_running(emulator):
        assert time.monotonic() < end, "the emulator is still there"
        time.sleep(0.05)


def is_running(process: int) -> bool:
    if sys.platform == "win32":
        listed = subprocess.run(["tasklist", "/FI", f"PID eq {process}"], stdout=subprocess.PIPE, text=True, check=True)
        return str(process) in listed.stdout
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    # One that nobody waited for is a zombie: it has ended.
    listed = subprocess.run(["ps", "-o", "stat=", "-p", str(process)], stdout=subprocess.PIPE, text=True)
    return bool(listed.stdout.strip()) and not listed.stdout.startswith("Z")


def test_a_port_that_is_free_again() -> None:
    with Emulator(link="tcp:127.0.0.1:0") as emulator:
        port = int(emulator.link.rsplit(":", 1)[1])
    with socket.socket() as free:
        free.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        free.bind(("127.0.0.1", port))
