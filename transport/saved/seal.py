"""A checksum of all bytes, appended to a file and verified before anything else is read.

HDF5 has checksums of its chunks, but not of its tables: a wrong bit there changes how numbers are unpacked,
or causes an endless loop.  HDF5, and other programs that read the file, ignore bytes after the end of its own
data.
"""

from __future__ import annotations

import io
import zlib
from typing import BinaryIO

MARK = b"\ntransport crc32 "  # then eight digits
LENGTH = len(MARK) + 8
STRETCH = 1 << 22  # bytes per read


def seal(file: BinaryIO) -> None:
    """Append the checksum to the file."""
    length = file.seek(0, io.SEEK_END)
    told = _checksum(file, length)
    file.seek(length)
    file.write(told)


def check_seal(file: BinaryIO) -> None:
    """Raise ValueError if the checksum is missing or wrong; otherwise rewind the file."""
    length = max(0, file.seek(0, io.SEEK_END) - LENGTH)
    file.seek(length)
    found = file.read()
    if not found.startswith(MARK):
        raise ValueError("its checksum is missing: it was cut off, or rewritten by another program")
    if found != _checksum(file, length):
        raise ValueError("its checksum is wrong: bytes were damaged or changed")
    file.seek(0)


def _checksum(file: BinaryIO, length: int) -> bytes:
    found, left = 0, length
    file.seek(0)
    while left and (piece := file.read(min(STRETCH, left))):
        found, left = zlib.crc32(piece, found), left - len(piece)
    return MARK + f"{found:08x}".encode()
