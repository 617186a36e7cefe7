"""The HTTP interface of a line. docs/panel.md has all of it, /api/v1/openapi.json its description."""

import json
from collections.abc import Mapping
from typing import Any, Final
from urllib.error import HTTPError, URLError
from urllib.request import ProxyHandler, Request, build_opener

# The panel is on this machine: no proxy of the environment stands between.
_OPENER: Final = build_opener(ProxyHandler({}))
_TIMEOUT: Final = 20.0


class ApiError(Exception):
    """A request that was refused, and changed nothing. The text says why."""

    def __init__(self, status: int, detail: str) -> None:
        super().__init__(detail)
        self.status = status
        """The HTTP status, such as 404 or 422; 0 if nobody answers."""
        self.detail = detail
        """The reason, a sentence."""


class Api:
    """The interface at `http://HOST:PORT`."""

    def __init__(self, panel: str) -> None:
        self.root = f"{panel}/api/v1"

    def get(self, path: str) -> dict[str, Any]:
        answer = self.request("GET", path)
        if not isinstance(answer, dict):
            raise ApiError(200, f"{path} answers with no object")
        return answer

    def request(self, method: str, path: str, body: Mapping[str, object] | None = None) -> object:
        """The answer, `None` if it is empty."""
        data = None if body is None else json.dumps(body).encode()
        headers = {} if body is None else {"Content-Type": "application/json"}
        try:
            with _OPENER.open(Request(self.root + path, data, headers, method=method), timeout=_TIMEOUT) as answer:
                octets: bytes = answer.read()
        except HTTPError as error:
            with error:
                raise ApiError(error.code, _detail(error.read())) from None
        except URLError as error:
            raise ApiError(0, f"nobody answers at {self.root}: has the emulator ended? ({error.reason})") from None
        result: object = json.loads(octets) if octets else None
        return result


def _detail(octets: bytes) -> str:
    try:
        return str(json.loads(octets)["detail"])
    except (ValueError, KeyError, TypeError):
        return octets.decode(errors="replace")
