"""A master under test, judged row by row."""

import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from ._binary import Process, ProfidriveError, default_link, run

_NO_REPORT = {2: "wrong arguments", 3: "no master or no data exchange", 5: "a file or the link fails"}


@dataclass(frozen=True, slots=True)
class Row:
    """A row of docs/judge.md, and what the master made of it."""

    id: str
    """Such as `M-F01`."""
    verdict: str
    """`pass`, `fail`, or why it was not judged, as docs/judge.md says."""
    reason: str
    text: str
    """What a master has to do."""
    telegrams: tuple[Any, ...]
    """That show it."""


@dataclass(frozen=True, slots=True)
class Report:
    """The verdicts, and how the judgement ended."""

    rows: tuple[Row, ...]
    ended: str
    """How it ended, such as `everything was tried`."""
    status: int
    """The exit status of `profidrive judge`: 0 passed and complete, 1 a row failed, 4 not finished or not enough judged."""

    @property
    def passed(self) -> bool:
        """Whether it went to its end, enough was judged, and no row failed. No failed row alone is no pass."""
        return self.status == 0

    @property
    def failed(self) -> tuple[Row, ...]:
        """The rows in which the master failed."""
        return tuple(row for row in self.rows if row.verdict == "fail")

    def __getitem__(self, id: str) -> Row:
        """The row of this name; `KeyError` if it was not judged."""
        for row in self.rows:
            if row.id == id:
                return row
        raise KeyError(id)


class Judge:
    """One run of `profidrive judge`: it plays the slaves for a master.

    >>> with Judge(["5,gsd=drive.gsd"], only=["M-F*"]) as judge:
    ...     start_my_master(judge.link)
    ...     assert judge.report(timeout=600).passed

    `options` are further arguments of `profidrive judge`. `Judge.of_capture` judges what a capture shows.
    """

    def __init__(
        self,
        stations: Sequence[str],
        *,
        link: str | None = None,
        only: Sequence[str] = (),
        options: Sequence[str] = (),
        timeout: float = 20.0,
    ) -> None:
        self._timeout = timeout
        self._process: Process | None = None
        self._files = tempfile.TemporaryDirectory(prefix="profidrive-")
        self._json = Path(self._files.name) / "verdicts.json"
        self._arguments = ["judge", "--link", link or default_link(), "--json", str(self._json)]
        for station in stations:
            self._arguments += ["--station", station]
        if only:
            self._arguments += ["--only", ",".join(only)]
        self._arguments += options
        self.link = ""
        """Where the master is to be connected."""

    def __enter__(self) -> Self:
        self._process = Process(self._arguments)
        (ready,) = self._process.ready(1, self._timeout)
        self.link = ready.link
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.end()
        self._files.cleanup()

    def report(self, timeout: float | None = None) -> Report:
        """Waits until everything was judged. `TimeoutError` if that takes longer than `timeout` seconds.

        `ProfidriveError` with the reason if no master came, or data exchange was never reached.
        """
        if self._process is None:
            raise ProfidriveError("the judge was not started; use it with 'with'")
        status = self._process.wait(timeout)
        return _report(self._json, status, self._process.log())

    @staticmethod
    def of_capture(capture: str | Path, *options: str) -> Report:
        """Judges what can be seen in a capture without provoking anything."""
        with tempfile.TemporaryDirectory(prefix="profidrive-") as folder:
            verdicts = Path(folder) / "verdicts.json"
            outcome = run("judge", "--json", str(verdicts), *options, str(capture))
            return _report(verdicts, outcome.returncode, outcome.stderr.splitlines())


def _report(verdicts: Path, status: int, log: list[str]) -> Report:
    # The file is made before the work, and stays empty where that does not end.
    text = verdicts.read_text(encoding="utf-8") if verdicts.exists() else ""
    if status in _NO_REPORT or not text:
        raise ProfidriveError("\n".join(log) or f"profidrive judge ended with {status}")
    report = json.loads(text)
    rows = tuple(
        Row(row["id"], row["verdict"], row["reason"], row["text"], tuple(row.get("telegrams", ())))
        for row in report["rows"]
    )
    return Report(rows, report["ended"], status)
