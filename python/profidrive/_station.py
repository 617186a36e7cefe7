"""A station that a device file (GSD) describes, seen and changed without the bus."""

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import quote

from ._api import Api
from ._events import Events, Kind

Place = tuple[int | str, int, str]
"""Slot or name of the module, octet in it, type: `(1, 0, "bit3")`, `("8 DI", 0, "unsigned8")`."""


class Station:
    """A station. Every property asks the emulator anew. docs/stations.md has the types of inputs and outputs."""

    def __init__(self, api: Api, address: int) -> None:
        self._api = api
        self.address = address
        """Its address."""

    def __repr__(self) -> str:
        return f"Station({self.address})"

    @property
    def state(self) -> dict[str, Any]:
        """Everything about it, as docs/stations.md says."""
        return self._api.get(self._path)

    @property
    def dp_state(self) -> str:
        """`WAIT-PRM`, `WAIT-CFG` or `DATA-EXCH`, as docs/panel.md says."""
        return str(self.state["dp_state"])

    def input(self, slot: int | str, octet: int, type: str) -> int | float:
        """An input as the master gets it."""
        return _number(self._api.get(self._place("inputs", (slot, octet, type))))

    def set_input(self, slot: int | str, octet: int, type: str, value: int | float) -> None:
        """Forces an input until `release_input`."""
        self._api.request("PUT", self._place("inputs", (slot, octet, type)), {"value": value})

    def release_input(self, slot: int | str, octet: int, type: str) -> None:
        """Gives an input back to what moves it by itself."""
        self._api.request("DELETE", self._place("inputs", (slot, octet, type)))

    def release_inputs(self) -> None:
        """Gives all inputs back to what moves them by themselves."""
        self._api.request("DELETE", f"{self._path}/inputs")

    def output(self, slot: int | str, octet: int, type: str) -> int | float:
        """An output as the station has it from its master."""
        return _number(self._api.get(self._place("outputs", (slot, octet, type))))

    def raise_diagnosis(
        self, *, bits: Sequence[int] = (), modules: Sequence[Mapping[str, object]] = (), **more: object
    ) -> None:
        """Has the diagnosis report this and nothing else, as docs/stations.md says."""
        self._api.request("PUT", f"{self._path}/diagnosis", {"bits": list(bits), "modules": list(modules), **more})

    def end_diagnosis(self) -> None:
        """Ends the diagnosis."""
        self._api.request("DELETE", f"{self._path}/diagnosis")

    def events(self, *kinds: Kind, interval_milliseconds: int = 100) -> Events:
        """The live stream of this station; `news` if no kind is given."""
        return Events(self._api.root, kinds or ("news",), self.address, interval_milliseconds)

    @property
    def _path(self) -> str:
        return f"/stations/{self.address}"

    def _place(self, what: str, place: Place) -> str:
        return "/".join([self._path, what, *(quote(str(part), safe="") for part in place)])


def _number(answer: dict[str, Any]) -> int | float:
    value = answer["value"]
    return value if isinstance(value, (int, float)) else float(value)
