"""The live stream of a line."""

import json
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPResponse
from typing import Any, Literal, Self
from urllib.parse import urlencode, urlsplit

from ._api import ApiError

Kind = Literal["state", "news", "telegram"]
"""What of the stream is wanted."""

_LONGEST_SILENCE = 30.0


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened on the line."""

    kind: str
    """`state`, `news`, `telegram`, which is a frame on a bus of CAN; `lost` tells what this reader missed."""
    data: dict[str, Any]
    """All that is known of it, as docs/panel.md says."""

    @property
    def time(self) -> float:
        """Seconds since the emulator started."""
        return float(self.data.get("time_seconds", 0.0))

    @property
    def line(self) -> str | None:
        """The name of the line it is about."""
        line = self.data.get("line")
        return None if line is None else str(line)

    @property
    def address(self) -> int | None:
        """The station it is about."""
        address = self.data.get("address")
        return None if address is None else int(address)

    @property
    def text(self) -> str:
        """In words, one line."""
        return str(self.data.get("text", ""))

    @property
    def octets(self) -> bytes:
        """Of a telegram."""
        return bytes.fromhex(str(self.data.get("octets_hex", "")))


class Events(Iterator[Event]):
    """An iterator of events, from its making to `close`, or the end of the emulator. Use it with `with`."""

    def __init__(self, root: str, kinds: tuple[Kind, ...], station: tuple[str, int] | None, interval_milliseconds: int) -> None:
        place = urlsplit(root)
        query: dict[str, object] = {"kinds": ",".join(kinds), "interval_milliseconds": interval_milliseconds}
        if station is not None:
            query["line"], query["address"] = station
        self._connection = HTTPConnection(place.hostname or "127.0.0.1", place.port, timeout=_LONGEST_SILENCE)
        self._connection.request("GET", f"{place.path}/events?{urlencode(query)}")
        self._response: HTTPResponse = self._connection.getresponse()
        self._closed = threading.Event()
        if self._response.status != 200:
            status, text = self._response.status, self._response.read().decode(errors="replace")
            self.close()
            raise ApiError(status, text)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __next__(self) -> Event:
        kind, data = "message", ""
        while not self._closed.is_set():
            try:
                line = self._response.readline().decode().rstrip("\r\n")
            except (OSError, ValueError):
                # Silence is no end: without changes only a comment keeps the stream alive.
                if self._closed.is_set():
                    break
                raise
            if line.startswith("event:"):
                kind = line[6:].strip()
            elif line.startswith("data:"):
                data += line[5:].strip()
            elif line == "" and data:
                return Event(kind, json.loads(data))
            elif line == "" and self._response.isclosed():
                break
        raise StopIteration

    def close(self) -> None:
        """Ends it. Asking twice changes nothing."""
        self._closed.set()
        self._connection.close()
        self._response.close()
