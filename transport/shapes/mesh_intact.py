"""Detects truncated mesh files, on which VTK's readers return garbage or crash the process.

Only lengths are compared, before anything is read: an STL file states its number of triangles or ends with a
keyword; the header of a PLY file states how many bytes or lines follow.
"""

import struct
from pathlib import Path

HEAD, TRIANGLE = 84, 50  # bytes of a binary STL file's header and of each triangle
LONGEST_HEADER = 1 << 20  # bytes
SIZES = {
    "char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2,
    "int": 4, "uint": 4, "int32": 4, "uint32": 4, "float": 4, "float32": 4, "double": 8, "float64": 8,
}  # fmt: skip


def why_not_whole(file: Path) -> str | None:
    """Reason why a file is truncated or not of the type of its suffix; None if nothing is wrong."""
    match file.suffix.lower():
        case ".stl":
            return _why_not_stl(file)
        case ".ply":
            return _why_not_ply(file)
    return None


def _why_not_stl(file: Path) -> str | None:
    """Reason why an STL file is truncated: too short for its number of triangles, or without an end."""
    size = file.stat().st_size
    with file.open("rb") as stream:
        head = stream.read(HEAD)
        stream.seek(max(0, size - 1024))
        tail = stream.read()
    if len(head) == HEAD:
        (triangles,) = struct.unpack("<I", head[80:])
        if size >= HEAD + TRIANGLE * triangles:
            return None
    if not head.lstrip().lower().startswith(b"solid"):
        return "a truncated STL file, or none"
    return None if b"endsolid" in tail.lower() else "text that does not end with 'endsolid'"


def _why_not_ply(file: Path) -> str | None:
    """Reason why a PLY file is truncated: shorter than its header promises."""
    with file.open("rb") as stream:
        start = stream.read(LONGEST_HEADER)
        header, mark, _ = start.partition(b"end_header")
        if not start.startswith(b"ply") or not mark:
            return "no PLY header"
        try:
            is_text, lines, least = _promised(header.decode("latin1"))
        except (KeyError, ValueError, IndexError) as error:
            return f"an invalid header ({error})"
        if not is_text:
            there = file.stat().st_size - len(header) - len(mark) - 1
            return None if there >= least else f"{there} bytes where the header promises at least {least}"
        stream.seek(len(header) + len(mark))
        there = sum(1 for line in stream if line.strip())
        return None if there >= lines else f"{there} lines where the header promises {lines}"


def _promised(header: str) -> tuple[bool, int, int]:
    """From the header: whether the data are text, the number of lines, and the least number of bytes."""
    is_text, lines, least, count = False, 0, 0, 0
    for words in filter(None, map(str.split, header.splitlines())):
        match words:
            case ["format", kind, *_]:
                is_text = kind == "ascii"
            case ["element", _, number]:
                count = int(number)
                lines += count
            case ["property", "list", length, item, name]:
                most = 3 if name.startswith("vertex_ind") else 0
                least += count * (SIZES[length] + most * SIZES[item])
            case ["property", kind, _]:
                least += count * SIZES[kind]
    return is_text, lines, least
