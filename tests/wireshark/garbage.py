#!/usr/bin/env python3
"""Writes a capture of telegrams that make little sense, for the dissector to survive.

    garbage.py FILE.pcapng PACKETS SEED

Random octets; telegrams whose frame is right and whose content is random; and those with some octets changed.
"""

import random
import struct
import sys


def frame(body, chance):
    fcs = sum(body) % 256
    if len(body) == 3:
        return b"\x10" + body + bytes([fcs, 0x16])
    if len(body) == 11 and chance.random() < 0.5:
        return b"\xa2" + body + bytes([fcs, 0x16])
    return bytes([0x68, len(body), len(body), 0x68]) + body + bytes([fcs, 0x16])


def octets(chance, most):
    return bytes(chance.randrange(256) for _ in range(chance.randrange(most)))


def packet(chance):
    kind = chance.randrange(4)
    if kind == 0:
        return octets(chance, 40)
    if kind == 1:
        return bytes([chance.choice((0x10, 0x68, 0xA2, 0xDC, 0xE5))]) + octets(chance, 12)
    saps = chance.randrange(4)
    da, sa = (chance.choice((2, 5, 127)) | saps % 2 * 0x80, chance.choice((2, 5)) | saps // 2 * 0x80)
    fc = chance.choice((0x49, 0x5D, 0x7D, 0x6D, 0x46, 0x08, 0x0A, 0x00, 0x02, 0x03, chance.randrange(256)))
    pdu = bytes(chance.choice((chance.randrange(55, 64), chance.randrange(256))) for _ in range(bin(saps).count("1")))
    if chance.random() < 0.05:
        pdu = b""
    pdu += chance.choice((octets(chance, 12), octets(chance, 240), bytes(chance.randrange(256) for _ in range(14))))
    whole = frame(bytes([da, sa, fc]) + pdu, chance)
    if kind == 2:
        return whole
    changed = bytearray(whole)
    changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed[: chance.randrange(1, len(changed) + 1)]) if chance.random() < 0.5 else bytes(changed)


def block(kind, body):
    body += bytes(-len(body) % 4)
    return struct.pack("<II", kind, len(body) + 12) + body + struct.pack("<I", len(body) + 12)


def write(path, packets, apart=1):
    """A capture of link type 257, `apart` microseconds between two packets."""
    with open(path, "wb") as file:
        file.write(block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)))
        file.write(block(1, struct.pack("<HHI", 257, 0, 0)))
        for number, data in enumerate(packets):
            file.write(block(6, struct.pack("<IIIII", 0, 0, number * apart, len(data), len(data)) + data))


def main():
    path, packets, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    chance = random.Random(seed)
    write(path, (packet(chance) for _ in range(packets)))


if __name__ == "__main__":
    main()
