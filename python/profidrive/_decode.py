"""Telegrams explained, by `profidrive decode`."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ._binary import ProfidriveError, run


@dataclass(frozen=True, slots=True)
class Field:
    """A part of a telegram, and what it means."""

    name: str
    raw: str
    meaning: str
    fields: "tuple[Field, ...]"


@dataclass(frozen=True, slots=True)
class Telegram:
    """A telegram explained. docs/decode.md lists all that `data` holds."""

    octets: bytes
    summary: str
    """One line."""
    mark: str
    """`plain`, or what is wrong with it: `invalid`, `mistake` and others of docs/decode.md."""
    hints: tuple[str, ...]
    fields: tuple[Field, ...]
    data: dict[str, Any]

    def __str__(self) -> str:
        sender, receiver = self.data.get("from"), self.data.get("to")
        way = "" if sender is None else f"{sender} -> {'all' if receiver is None else receiver}  "
        return f"{way}{self.summary}" if self.mark == "plain" else f"{way}{self.mark}: {self.summary}"


def decode(octets: bytes | str | Iterable[bytes | str], *options: str) -> list[Telegram]:
    """Explains telegrams: octets, or text in hexadecimal, one telegram each.

    Telegrams are explained one after the other: a reply has its request before it. `options` are those of `profidrive
    decode`, such as `--mode=velocity`.
    """
    lines = [octets] if isinstance(octets, (bytes, str)) else list(octets)
    text = "\n".join(line.hex(" ") if isinstance(line, bytes) else line for line in lines)
    return _telegrams(run("decode", "--json", *options, "-", stdin=text + "\n"))


def decode_file(file: str | Path, *options: str) -> list[Telegram]:
    """Explains a capture (pcapng) or a text file. A capture that is still written can be read."""
    return _telegrams(run("decode", "--json", *options, str(file)))


def _telegrams(outcome: Any) -> list[Telegram]:
    telegrams = []
    for line in outcome.stdout.splitlines():
        data = json.loads(line)
        if "kind" in data:
            octets = bytes.fromhex(data.get("octets", ""))
            hints = tuple(_hints(data))
            telegrams.append(
                Telegram(octets, data["summary"], data["mark"], hints, _fields(data.get("fields", ())), data)
            )
    if not telegrams and outcome.returncode:
        raise ProfidriveError(outcome.stderr.strip())
    return telegrams


def _hints(data: dict[str, Any]) -> Iterator[str]:
    for hint in data.get("hints", ()):
        yield hint if isinstance(hint, str) else str(hint.get("text", hint))


def _fields(fields: Iterable[dict[str, Any]]) -> tuple[Field, ...]:
    return tuple(
        Field(field["name"], field["raw"], field["meaning"], _fields(field.get("fields", ()))) for field in fields
    )
