"""A drive on the line, seen and changed without the bus."""

from collections.abc import Iterator
from typing import Any, Literal, TypedDict, Unpack

from ._api import Api
from ._events import Events, Kind


class InputsChange(TypedDict, total=False):
    """What acts on a drive from outside. What is left out stays. docs/panel.md has the ranges."""

    control_supply_volts: float
    output_supply_volts: float
    enable: bool
    battery_volts: float
    load_torque_newton_metres: float
    friction_torque_newton_metres: float
    blocked: bool
    internal_fault: bool
    encoder_fault: bool
    ambient_temperature_celsius: float
    stage_temperature_celsius: float | None
    """`None`: what the plant makes of it."""
    dc_link_volts: float | None
    """`None`: what the plant makes of it."""


class Word:
    """A word of 16 bits whose bits have names: `"ready-to-travel" in drive.zsw`, `drive.zsw.value`."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.value: int = data["value"]
        self._bits: dict[str, bool] = {bit["key"]: bit["set"] for bit in data["bits"] if bit["key"]}

    def __contains__(self, name: str) -> bool:
        """Whether the bit of this name is set. A name that does not exist is a `KeyError`, not `False`."""
        return self._bits[name]

    def __iter__(self) -> Iterator[str]:
        """The names of the bits that are set."""
        return (name for name, is_set in self._bits.items() if is_set)

    def __int__(self) -> int:
        return self.value

    def __repr__(self) -> str:
        return f"<{self.value:04X}: {', '.join(self)}>"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all bits, set or not, from bit 0."""
        return tuple(self._bits)


class Drive:
    """A drive. Every property asks the emulator anew."""

    def __init__(self, api: Api, address: int) -> None:
        self._api = api
        self.address = address
        """Its address, of a CANopen node its number."""

    def __repr__(self) -> str:
        return f"Drive({self.address})"

    @property
    def state(self) -> dict[str, Any]:
        """Everything about it, as docs/panel.md says."""
        return self._api.get(self._path)

    @property
    def stw(self) -> Word:
        """The control word, the newest of the master."""
        return self._word("stw")

    @property
    def zsw(self) -> Word:
        """The status word, as the master gets it next."""
        return self._word("zsw")

    @property
    def ssw(self) -> Word:
        """The system status word."""
        return self._word("ssw")

    @property
    def position(self) -> int:
        """In user units."""
        return int(self.state["position_user_units"])

    @property
    def velocity(self) -> int:
        """In rpm."""
        return int(self.state["velocity_rpm"])

    @property
    def dp_state(self) -> str:
        """`WAIT-PRM`, `WAIT-CFG` or `DATA-EXCH`, as docs/panel.md says."""
        return str(self.state["dp_state"])

    @property
    def fault(self) -> str | None:
        """The fault that is latched, by its letter."""
        fault = self.state["fault"]
        return None if fault is None else str(fault)

    @property
    def why(self) -> str:
        """What keeps it from moving, in words, with the control words to send."""
        return str(self._api.get(f"{self._path}/why")["text"])

    @property
    def inputs(self) -> dict[str, Any]:
        """What acts on it from outside."""
        inputs: dict[str, Any] = self.state["inputs"]
        return inputs

    def set_inputs(self, **change: Unpack[InputsChange]) -> None:
        """Changes what acts on it from outside: `drive.set_inputs(blocked=True)`."""
        self._api.request("PATCH", f"{self._path}/inputs", {**change})

    def reset_inputs(self) -> None:
        """All nominal again: 24 V, a good battery, no load, nothing blocked."""
        self._api.request("DELETE", f"{self._path}/inputs")

    def provoke(self, fault: str) -> None:
        """Does whatever it takes for a fault: `A` to `J`, of other devices the names of docs/panel.md."""
        self._api.request("POST", f"{self._path}/provoke", {"fault": fault})

    def power(self, on: bool) -> None:
        """Switches the control supply on or off."""
        self._api.request("PUT", f"{self._path}/power", {"on": on})

    def key(self, key: str, pressed: bool = True) -> None:
        """Presses a key of the drive, which stays pressed, or releases it."""
        self._api.request("POST", f"{self._path}/keys", {"key": key, "pressed": pressed})

    def parameter(self, pnu: int, subindex: int | None = None) -> int:
        """Reads a parameter without the bus: no master sees a job."""
        query = "" if subindex is None else f"?subindex={subindex}"
        return int(self._api.get(f"{self._path}/parameters/{pnu}{query}")["value"])

    def set_parameter(self, pnu: int, value: int) -> None:
        """Writes a parameter without the bus, with the checks that the bus has."""
        self._api.request("PUT", f"{self._path}/parameters/{pnu}", {"value": value})

    def events(self, *kinds: Kind, interval_milliseconds: int = 100) -> Events:
        """The live stream of this drive; `news` if no kind is given."""
        return Events(self._api.root, kinds or ("news",), self.address, interval_milliseconds)

    @property
    def _path(self) -> str:
        return f"/drives/{self.address}"

    def _word(self, name: Literal["stw", "zsw", "ssw"]) -> Word:
        return Word(self.state["words"][name])
