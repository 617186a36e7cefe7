"""Faults on the line."""

from typing import Any, Self

from ._api import Api, ApiError


class LineFault:
    """A fault on the line until `remove`, or the end of its `with` block."""

    def __init__(self, api: Api, faults: str, number: int, spec: str) -> None:
        self._api = api
        self._faults = faults
        self.number = number
        """By which the emulator knows it."""
        self.spec = spec
        """As docs/faults.md writes it, such as `late=20ms,station=5`."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.remove()

    @property
    def injected(self) -> int:
        """How often it was injected."""
        return next((int(fault["injected"]) for fault in self._all() if fault["number"] == self.number), 0)

    def remove(self) -> None:
        """Takes it off the line. Asking twice changes nothing."""
        try:
            self._api.request("DELETE", f"{self._faults}/{self.number}")
        except ApiError as error:
            if error.status != 404:
                raise

    def _all(self) -> list[dict[str, Any]]:
        faults: list[dict[str, Any]] = self._api.get(self._faults)["faults"]
        return faults
