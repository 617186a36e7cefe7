"""Where the command is, and how it is started and ended."""

import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import threading
import time
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Final

_LOG_LINES: Final = 1000
_READY: Final = re.compile(r"ready link=(?P<link>.*?)(?P<rest>(?: (?:drives|stations|nodes|panel|metrics)=\S+)*)$")


class ProfidriveError(Exception):
    """The command did not start, or did not do what was asked. The text is what it says itself."""


def binary() -> Path:
    """The program: that of the environment variable PROFIDRIVE, else that of this package, else that of PATH."""
    if named := os.environ.get("PROFIDRIVE"):
        return Path(named)
    name = "profidrive.exe" if sys.platform == "win32" else "profidrive"
    for scripts in (sysconfig.get_path("scripts"), str(Path(sys.executable).parent)):
        if (installed := Path(scripts) / name).is_file():
            return installed
    if found := shutil.which("profidrive"):
        return Path(found)
    raise ProfidriveError("there is no program profidrive; install the package, or set PROFIDRIVE to its path")


def default_link() -> str:
    """Where a line is if nothing is said: a new pseudo-terminal, on other systems than Linux a free TCP port."""
    return "pty" if sys.platform == "linux" else "tcp:127.0.0.1:0"


def run(*arguments: str, stdin: str | None = None) -> subprocess.CompletedProcess[str]:
    """Runs the command to its end."""
    command = [str(binary()), *arguments]
    return subprocess.run(command, input=stdin, capture_output=True, text=True, encoding="utf-8", check=False)


class Ready:
    """A ready line: `ready link=... drives=5,6 stations=7 panel=http://... metrics=http://...`."""

    def __init__(self, line: str) -> None:
        found = _READY.match(line.strip())
        if not found:
            raise ProfidriveError(f"expected a ready line, got: {line.strip()!r}")
        words = dict(word.split("=", 1) for word in found["rest"].split())
        self.link: str = found["link"]
        self.panel: str | None = words.get("panel")
        self.metrics: str | None = words.get("metrics")
        self.drives: tuple[int, ...] = _addresses(words.get("drives", words.get("nodes", "")))
        self.stations: tuple[int, ...] = _addresses(words.get("stations", ""))


def _addresses(text: str) -> tuple[int, ...]:
    addresses: list[int] = []
    for part in filter(None, text.split(",")):
        first, _, last = part.partition("-")
        addresses.extend(range(int(first), int(last or first) + 1))
    return tuple(addresses)


class Process:
    """The command while it runs. What it logs is kept, the last 1000 lines."""

    def __init__(self, arguments: Sequence[str]) -> None:
        flags = 0
        if sys.platform == "win32":
            # Ctrl-Break reaches a whole group: one of its own.
            flags = subprocess.CREATE_NEW_PROCESS_GROUP
        self._process = subprocess.Popen(
            # It ends with this process, also if that is killed: the pipe ends then.
            [str(binary()), *arguments, "--end-with-stdin"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            creationflags=flags,
        )
        self._log: deque[str] = deque(maxlen=_LOG_LINES)
        self._said: list[str] = []
        self._changed = threading.Condition()
        self._over = False
        self._threads = [
            threading.Thread(target=self._listen, daemon=True),
            threading.Thread(target=self._keep_log, daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def ready(self, count: int, timeout: float) -> list[Ready]:
        """Waits for so many ready lines."""
        end = time.monotonic() + timeout
        with self._changed:
            while len(self._said) < count and not self._over:
                if (left := end - time.monotonic()) <= 0:
                    break
                self._changed.wait(left)
            lines = self._said[:count]
        if len(lines) == count:
            return [Ready(line) for line in lines]
        failed = self._process.poll() is not None or self._over
        self.end()
        raise ProfidriveError("\n".join(self.log()) if failed else f"profidrive was not ready within {timeout:g} s")

    def wait(self, timeout: float | None) -> int:
        """Waits for the end by itself; the exit status."""
        try:
            status = self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"profidrive has not ended within {timeout:g} s") from None
        self._join()
        return status

    def end(self, patience: float = 10.0) -> int:
        """Ends it as Ctrl-C does; the exit status."""
        if self._process.poll() is None:
            if sys.platform == "win32":
                self._process.send_signal(signal.CTRL_BREAK_EVENT)
            else:
                self._process.terminate()
            try:
                self._process.wait(patience)
            except subprocess.TimeoutExpired:
                self._process.kill()
        status = self._process.wait()
        self._join()
        return status

    @property
    def pid(self) -> int:
        return self._process.pid

    def is_running(self) -> bool:
        return self._process.poll() is None

    def log(self) -> list[str]:
        """What it said on stderr, oldest first."""
        return list(self._log)

    def _join(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        for thread in self._threads:
            thread.join(5)

    def _listen(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stdout:
            for line in stdout:
                with self._changed:
                    self._said.append(line)
                    self._changed.notify_all()
        with self._changed:
            self._over = True
            self._changed.notify_all()

    def _keep_log(self) -> None:
        assert self._process.stderr is not None
        with self._process.stderr as stderr:
            self._log.extend(line.rstrip("\n") for line in stderr)
