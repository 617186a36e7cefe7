"""A station on a line of either bus, seen and changed without the bus."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, Self
from urllib.parse import quote

from ._api import Api, ApiError
from ._events import Events, Kind

Number = int | float
"""A value as JSON has it."""

_CONTROL_WORDS: Final = ("stw", "6040")
_STATUS_WORDS: Final = ("zsw", "6041")
_WAIT_STEP: Final = 0.02


class Word:
    """A word of 16 bits whose bits have names: `"ready-to-travel" in drive.zsw`, `drive.zsw.value`."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.value: int = data["value"]
        self._bits: dict[str, bool] = {_name_of(bit): bit["set"] for bit in data["bits"] if bit["name"]}

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
    """A station: a drive, a node, a station of a device file. Every property asks the emulator anew.

    What a station does not have is a `KeyError` that says what it has, or an `ApiError` with the sentence of the emulator.
    """

    def __init__(self, api: Api, line: str, address: int) -> None:
        self._api = api
        self.line = line
        """The name of its line."""
        self.address = address
        """Its address, of a CANopen node its number."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.address})"

    # What it is.

    @property
    def state(self) -> dict[str, Any]:
        """Everything about it, as docs/panel.md says."""
        return self._api.get(self._path)

    @property
    def device(self) -> str:
        """What it is, as the command line names it."""
        return str(self.state["device"])

    @property
    def bus_state(self) -> str | None:
        """Its state on the bus: `WAIT-PRM`, `WAIT-CFG`, `DATA-EXCH`; of a node that of NMT. `None` while it is off."""
        state = self.state["bus_state"]
        return None if state is None else str(state)

    @property
    def dp_state(self) -> str | None:
        """`bus_state`, by the name that it had for PROFIBUS."""
        return self.bus_state

    @property
    def words(self) -> Mapping[str, Word]:
        """Its words by key: `stw` and `zsw`, of a node `6040` and `6041`."""
        return {word["key"]: Word(word) for word in self.state["words"]}

    @property
    def stw(self) -> Word:
        """The control word, the newest of the master; of a node object 6040h."""
        return self._word(*_CONTROL_WORDS)

    @property
    def zsw(self) -> Word:
        """The status word, as the master gets it next; of a node object 6041h."""
        return self._word(*_STATUS_WORDS)

    @property
    def ssw(self) -> Word:
        """The system status word, of a drive that has one."""
        return self._word("ssw")

    @property
    def values(self) -> Mapping[str, Any]:
        """What is measured and counted, by key and in the unit that `state` tells: `drive.values["current"]`."""
        return {value["key"]: value["value"] for value in self.state["values"]}

    @property
    def position(self) -> Number:
        """In the unit of its positions."""
        return self._value("position")

    @property
    def velocity(self) -> Number:
        """In rpm."""
        return self._value("speed")

    @property
    def fault(self) -> str | None:
        """The fault that is latched: its letter, number or code."""
        fault = self.state["fault"]
        return None if fault is None else str(fault["fault"])

    @property
    def why(self) -> str:
        """What keeps it from moving, in words, with what to send next."""
        return str(self._api.get(f"{self._path}/why")["text"])

    @property
    def samples(self) -> list[dict[str, Any]]:
        """Its curves of the last minutes: `time_seconds` and values by key."""
        samples: list[dict[str, Any]] = self._api.get(f"{self._path}/samples")["samples"]
        return samples

    # What acts on it from outside.

    @property
    def inputs(self) -> dict[str, Any]:
        """What acts on it from outside."""
        return self._api.get(f"{self._path}/inputs")

    def set_inputs(self, **change: Number | None) -> None:
        """Changes what acts on it from outside: `drive.set_inputs(blocked=True)`. What is left out stays."""
        self._api.request("PATCH", f"{self._path}/inputs", change)

    def reset_inputs(self) -> None:
        """All nominal again: a good supply, no load, nothing blocked; of a station of a device file nothing forced."""
        self._api.request("DELETE", f"{self._path}/inputs")

    def provoke(self, fault: str, provoked: bool = True) -> None:
        """Does whatever it takes for a fault that `state["faults"]` lists, or takes its cause back."""
        self._api.request("POST", f"{self._path}/provoke", {"fault": fault, "provoked": provoked})

    def power(self, on: bool) -> None:
        """Switches the control supply on or off."""
        self._api.request("PUT", f"{self._path}/power", {"on": on})

    def key(self, key: str, pressed: bool = True, *, lease_milliseconds: int | None = None) -> None:
        """Presses a key, which stays pressed until it is released, or until its lease ends; or releases it."""
        lease = {} if lease_milliseconds is None else {"lease_milliseconds": lease_milliseconds}
        self._api.request("POST", f"{self._path}/keys", {"key": key, "pressed": pressed, **lease})

    def set_switches(self, positions: Sequence[bool]) -> None:
        """Sets the DIP switches, SW1 first. They are read when the station is switched on."""
        self._api.request("PUT", f"{self._path}/switches", {"positions": list(positions)})

    def unplug(self) -> None:
        """Takes it off the line."""
        self._api.request("DELETE", self._path)

    # Parameters and objects, past the bus.

    def parameter(self, pnu: int, subindex: int | None = None) -> Number:
        """Reads a parameter without the bus: no master sees a job."""
        return _number(self._api.get(self._parameter(pnu, subindex)))

    def set_parameter(self, pnu: int, value: Number, subindex: int | None = None) -> None:
        """Writes a parameter without the bus, with the checks that the bus has."""
        self._api.request("PUT", self._parameter(pnu, subindex), {"value": value})

    def read_object(self, index: int, sub: int = 0) -> Any:
        """Reads an object of the dictionary of a node without the bus: `drive.read_object(0x6041)`."""
        return self._api.get(self._object(index, sub))["value"]

    def write_object(self, index: int, value: Number | str, sub: int = 0) -> None:
        """Writes an object without the bus, with the checks that an SDO has."""
        self._api.request("PUT", self._object(index, sub), {"value": value})

    # Inputs, outputs and diagnosis of a station that a device file describes (docs/stations.md).

    def input(self, slot: int | str, octet: int, type: str) -> Number:
        """An input as the master gets it: slot or name of the module, octet in it, type such as `bit3`, `unsigned8`."""
        return _number(self._api.get(self._place("inputs", slot, octet, type)))

    def set_input(self, slot: int | str, octet: int, type: str, value: Number) -> None:
        """Forces an input until `release_input`."""
        self._api.request("PUT", self._place("inputs", slot, octet, type), {"value": value})

    def release_input(self, slot: int | str, octet: int, type: str) -> None:
        """Gives an input back to what moves it by itself."""
        self._api.request("DELETE", self._place("inputs", slot, octet, type))

    def release_inputs(self) -> None:
        """Gives all inputs back to what moves them by themselves."""
        self.reset_inputs()

    def output(self, slot: int | str, octet: int, type: str) -> Number:
        """An output as the station has it from its master."""
        return _number(self._api.get(self._place("outputs", slot, octet, type)))

    def raise_diagnosis(
        self, *, bits: Sequence[int] = (), modules: Sequence[Mapping[str, object]] = (), **more: object
    ) -> None:
        """Has the diagnosis report this and nothing else, as docs/stations.md says."""
        self._api.request("PUT", f"{self._path}/diagnosis", {"bits": list(bits), "modules": list(modules), **more})

    def end_diagnosis(self) -> None:
        """Ends the diagnosis."""
        self._api.request("DELETE", f"{self._path}/diagnosis")

    # Records and alarms of a station of DP-V1 (docs/stations.md).

    @property
    def records(self) -> dict[tuple[int, int], bytes]:
        """What is in its records, by slot and index: `station.records[1, 10]`."""
        records = self._api.get(f"{self._path}/records")["records"]
        return {(record["slot"], record["index"]): bytes.fromhex(record["data"]) for record in records}

    def set_record(self, slot: int, index: int, data: bytes) -> None:
        """Changes a record as the device does, also one that a master cannot write: as many octets as it has."""
        self._api.request("PUT", f"{self._path}/records/{slot}/{index}", {"data": data.hex()})

    @property
    def alarms(self) -> list[dict[str, Any]]:
        """The alarms that the master has not acknowledged, each `pending` or `delivered` in `state`."""
        alarms: list[dict[str, Any]] = self._api.get(f"{self._path}/alarms")["alarms"]
        return alarms

    def raise_alarm(
        self, type: int | str, slot: int = 0, *, specifier: str = "none", additional_ack: bool = False, data: bytes = b""
    ) -> dict[str, Any]:
        """Raises an alarm: `process`, `diagnostic`, `pull`, `plug`, `status`, `update` or a number.

        `specifier` is `none`, `appears`, `disappears` or `still`. The answer is the alarm, as in `alarms`. An `ApiError` says
        why it may not come: no master in data exchange, a type that the master or the device file does not have.
        """
        alarm = {"type": type, "slot": slot, "specifier": specifier, "additional_ack": additional_ack, "data": data.hex()}
        answer = self._api.request("POST", f"{self._path}/alarms", alarm)
        assert isinstance(answer, dict)
        return answer

    def forget_alarms(self) -> None:
        """Forgets every alarm, as if none had been raised."""
        self._api.request("DELETE", f"{self._path}/alarms")

    def send_status(self, type: int, slot: int = 0, *, specifier: str = "none", data: bytes = b"") -> None:
        """Sends a status message, which nobody acknowledges."""
        message = {"type": type, "slot": slot, "specifier": specifier, "data": data.hex()}
        self._api.request("POST", f"{self._path}/status-messages", message)

    @property
    def acyclic(self) -> dict[str, Any]:
        """The channel of the owner, the connections of masters of class 2, identification and maintenance."""
        return self._api.get(f"{self._path}/acyclic")

    # What happens.

    def events(self, *kinds: Kind, interval_milliseconds: int = 100) -> Events:
        """The live stream of this station; `news` if no kind is given."""
        return Events(self._api.root, kinds or ("news",), (self.line, self.address), interval_milliseconds)

    def wait_until(self, condition: Callable[[Self], object], timeout: float = 10.0) -> None:
        """Waits until something holds: `drive.wait_until(lambda drive: drive.position > 1000)`.

        After `timeout` seconds a `TimeoutError` says what keeps the drive from moving.
        """
        end = time.monotonic() + timeout
        while not condition(self):
            if time.monotonic() > end:
                raise TimeoutError(f"{self!r}: not as wanted within {timeout:g} s; {self._reason()}")
            time.sleep(_WAIT_STEP)

    def wait_for_fault(self, fault: str | None = None, timeout: float = 10.0) -> str:
        """Waits until this fault is latched, or any; the fault."""
        found: list[str] = []

        def latched(drive: Drive) -> bool:
            found[:] = [drive.fault or ""]
            return found[0] == fault if fault is not None else found[0] != ""

        self.wait_until(latched, timeout)
        return found[0]

    def _reason(self) -> str:
        try:
            return self.why
        except ApiError as error:
            return error.detail

    @property
    def _path(self) -> str:
        return f"/lines/{quote(self.line, safe='')}/stations/{self.address}"

    def _word(self, *keys: str) -> Word:
        words = self.words
        for key in keys:
            if key in words:
                return words[key]
        raise KeyError(f"{self!r} has no word {keys[0]!r}; it has {', '.join(words) or 'none'}")

    def _value(self, key: str) -> Number:
        values = self.values
        if key not in values:
            raise KeyError(f"{self!r} has no value {key!r}; it has {', '.join(values) or 'none'}")
        return _number({"value": values[key]})

    def _parameter(self, pnu: int, subindex: int | None) -> str:
        return f"{self._path}/parameters/{pnu}" + ("" if subindex is None else f".{subindex}")

    def _object(self, index: int, sub: int) -> str:
        return f"{self._path}/objects/{index:X}/{sub:X}"

    def _place(self, what: str, *place: int | str) -> str:
        return "/".join([self._path, what, *(quote(str(part), safe="") for part in place)])


Station = Drive
"""A station that a device file describes: asked as every other one."""


def _name_of(bit: Mapping[str, Any]) -> str:
    """The short name of a bit, made of the name in the manual where there is none."""
    return str(bit["key"] or bit["name"].replace(" ", "-"))


def _number(answer: Mapping[str, Any]) -> Number:
    value = answer["value"]
    return value if isinstance(value, (int, float)) else float(value)
