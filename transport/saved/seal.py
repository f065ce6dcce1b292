"""A seal behind the end of a file: the checksum of all its bytes, looked at before anything else is.

HDF5 has checksums of its chunks, but none of its tables: a wrong bit there is another way to unpack, so other numbers, or a
loop without an end.  What it does not know of, behind its own end, it leaves alone, as do other programs that read it.
"""

from __future__ import annotations

import io
import zlib
from typing import BinaryIO

MARK = b"\ntransport crc32 "  # then eight digits
LENGTH = len(MARK) + 8
STRETCH = 1 << 22  # bytes that are read together


def seal(file: BinaryIO) -> None:
    """Write it behind all that is there."""
    length = file.seek(0, io.SEEK_END)
    told = _checksum(file, length)
    file.seek(length)
    file.write(told)


def check_seal(file: BinaryIO) -> None:
    """Raises ValueError where the file is not as it was when it was sealed; where it is, it stands at its beginning."""
    length = max(0, file.seek(0, io.SEEK_END) - LENGTH)
    file.seek(length)
    found = file.read()
    if not found.startswith(MARK):
        raise ValueError("its seal is missing: it was cut off, or written anew by another program")
    if found != _checksum(file, length):
        raise ValueError("its seal tells of other bytes: some were damaged or changed")
    file.seek(0)


def _checksum(file: BinaryIO, length: int) -> bytes:
    found, left = 0, length
    file.seek(0)
    while left and (piece := file.read(min(STRETCH, left))):
        found, left = zlib.crc32(piece, found), left - len(piece)
    return MARK + f"{found:08x}".encode()
