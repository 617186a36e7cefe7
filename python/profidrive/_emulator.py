"""Drives and stations on a line."""

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self, TypeVar
from urllib.parse import quote

from ._api import Api
from ._binary import Process, ProfidriveError, Ready, default_link
from ._decode import Telegram, decode_file
from ._drive import Drive, Station
from ._events import Events, Kind
from ._faults import LineFault


_T = TypeVar("_T")


class _ByAddress(dict[int, _T]):
    """Says which addresses there are where one is not."""

    def __missing__(self, address: int) -> _T:
        raise KeyError(f"there is no station at address {address}; there are {', '.join(map(str, self)) or 'none'}")


class Line:
    """A line and everybody on it."""

    def __init__(self, ready: Ready, place: int = 0) -> None:
        self._api = Api(ready.panel) if ready.panel else None
        self.name = "" if self._api is None else _name_of(self._api, place)
        """Its name in the panel; empty without one."""
        self.link = ready.link
        """What a master opens: a terminal such as `/dev/pts/3`, or `tcp:HOST:PORT`."""
        self.panel = ready.panel
        """The page for browsers; `None` if a line file asks for none."""
        self.metrics = ready.metrics
        """What Prometheus reads (docs/metrics.md); `None` without `options=["--metrics", "127.0.0.1:0"]`."""
        described = set(ready.stations)
        drives = [address for address in ready.drives if address not in described] if self._api else []
        self.drives: Mapping[int, Drive] = _ByAddress(
            (address, Drive(self._known, self.name, address)) for address in drives
        )
        """The drives, or the nodes of a bus of CAN, by address, as they were at the start."""
        stations = ready.stations if self._api else []
        self.stations: Mapping[int, Station] = _ByAddress(
            (address, Station(self._known, self.name, address)) for address in stations
        )
        """The stations that a device file describes, by address, as they were at the start."""

    @property
    def state(self) -> dict[str, Any]:
        """Stations, counters and faults of the line, as docs/panel.md says."""
        return self._known.get(self._path)

    def add(self, address: int, device: str, **specification: object) -> Drive:
        """Plugs in a station, with the options of its device. `state["devices"]` lists what there is."""
        body = {"line": self.name, "address": address, "device": device, **specification}
        self._known.request("POST", "/stations", body)
        return Drive(self._known, self.name, address)

    def inject(self, fault: str) -> LineFault:
        """Puts a fault on the line: `line.inject("late=20ms,station=5")`, as docs/faults.md says. With `with` it ends by itself."""
        answer = self._known.request("POST", self._faults, {"fault": fault})
        number = answer.get("number") if isinstance(answer, dict) else None
        if not isinstance(number, int):
            raise ProfidriveError(f"the emulator gave the fault {fault} no number")
        return LineFault(self._known, self._faults, number, fault)

    def clear_faults(self) -> None:
        """Takes all faults off the line."""
        self._known.request("DELETE", self._faults)

    def events(self, *kinds: Kind, interval_milliseconds: int = 100) -> Events:
        """The live stream of the panel of the line; `news` if no kind is given."""
        return Events(self._known.root, kinds or ("news",), None, interval_milliseconds)

    @property
    def _path(self) -> str:
        return f"/lines/{quote(self.name, safe='')}"

    @property
    def _faults(self) -> str:
        return f"{self._path}/faults"

    @property
    def _known(self) -> Api:
        if self._api is None:
            raise ProfidriveError('the line has no panel; add panel = "127.0.0.1:0" to its table in the file')
        return self._api


class Lines(tuple[Line, ...]):
    """Lines in order, by place or by name: `emulator.lines[0]`, `emulator.lines["cellar"]`."""

    def __getitem__(self, key: Any) -> Any:
        if not isinstance(key, str):
            return super().__getitem__(key)
        for line in self:
            if line.name == key:
                return line
        raise KeyError(f"there is no line {key!r}; there are {', '.join(line.name for line in self)}")


class Emulator(Line):
    """One run of `profidrive emulate`, from `with` to its end.

    >>> with Emulator(drives=[5, "6,gear=24"], stations=["7,gsd=io.gsd"]) as emulator:
    ...     master = MyMaster(emulator.link)
    ...     emulator.drives[5].set_inputs(blocked=True)

    Either a line file (docs/line.md), then `lines` has each of its lines and the emulator itself is the first; or drives,
    stations, link and capture. `options` are further arguments of `profidrive emulate`.
    """

    def __init__(
        self,
        drives: Sequence[int | str] | None = None,
        stations: Sequence[str] = (),
        line: str | Path | None = None,
        *,
        nodes: Sequence[int | str] = (),
        link: str | None = None,
        faults: Sequence[str] = (),
        capture: str | Path | None = None,
        state_dir: str | Path | None = None,
        options: Sequence[str] = (),
        timeout: float = 20.0,
    ) -> None:
        self._timeout = timeout
        self._process: Process | None = None
        self._lines = 1
        self.lines: Lines = Lines(())
        """Every line of the file, in order, also by name; without a file the one line."""
        self.capture: Path | None = None if capture is None else Path(capture)
        """Where the telegrams are written (pcapng), if anywhere."""
        if line is not None:
            if drives is not None or stations or nodes or link or faults or capture or state_dir:
                raise ValueError("a line file says everything: give nothing beside line=")
            self._arguments = ["emulate", "--line", str(line), *options]
            self._lines = _lines_of(Path(line).read_bytes())
            return
        arguments = ["emulate", "--panel", "127.0.0.1:0"]
        arguments += ["--link", link or ("slcan-tcp:127.0.0.1:0" if nodes else default_link())]
        if drives is None and not stations and not nodes:
            drives = [5]
        for flag, values in (
            ("--drive", drives or ()),
            ("--station", stations),
            ("--node", nodes),
            ("--fault", faults),
        ):
            for value in values:
                arguments += [flag, str(value)]
        if capture is not None:
            arguments += ["--capture", str(capture)]
        if state_dir is not None:
            arguments += ["--state-dir", str(state_dir)]
        self._arguments = [*arguments, *options]

    def __enter__(self) -> Self:
        if self._process is not None:
            raise ProfidriveError("this emulator was started already; make another one")
        self._process = Process(self._arguments)
        first, *others = self._process.ready(self._lines, self._timeout)
        super().__init__(first)
        self.lines = Lines((self, *(Line(ready, place) for place, ready in enumerate(others, 1))))
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends it as Ctrl-C does. Asking twice changes nothing."""
        if self._process is not None:
            self._process.end()

    @property
    def log(self) -> list[str]:
        """What it logged, oldest first, the last 1000 lines."""
        return self._process.log() if self._process else []

    def telegrams(self) -> list[Telegram]:
        """What has passed so far, explained; it needs `capture`."""
        if self.capture is None:
            raise ProfidriveError("nothing is captured; give the emulator capture=FILE")
        return decode_file(self.capture)


def _name_of(api: Api, place: int) -> str:
    """The name of a line: of the only one that its panel shows, or of the one at its place."""
    lines = api.get("/lines")["lines"]
    return str(lines[place if len(lines) > 1 else 0]["line"])


def _lines_of(file: bytes) -> int:
    """How many lines a line file has. Of a file that is none, `profidrive` says what is wrong."""
    try:
        lines = tomllib.loads(file.decode("utf-8-sig")).get("line", [])
    except (tomllib.TOMLDecodeError, UnicodeDecodeError):
        return 1
    return len(lines) if isinstance(lines, list) else 1
