"""Whether a file of triangles is whole: of one that was cut off, VTK's readers make garbage, or end the process.

Looks at lengths only, before anything is read: an STL file says how many triangles it holds, or ends with a word; a PLY
file's header says how many bytes or lines must follow.
"""

import struct
from pathlib import Path

HEAD, TRIANGLE = 84, 50  # bytes of a binary STL file
LONGEST_HEADER = 1 << 20  # bytes of a PLY file
SIZES = {
    "char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2, "int": 4, "uint": 4,
    "int32": 4, "uint32": 4, "float": 4, "float32": 4, "double": 8, "float64": 8,
}  # fmt: skip


def why_not_whole(file: Path) -> str | None:
    """What shows that a file is cut off or of another kind than its name says; None where nothing does."""
    match file.suffix.lower():
        case ".stl":
            return _why_not_stl(file)
        case ".ply":
            return _why_not_ply(file)
    return None


def _why_not_stl(file: Path) -> str | None:
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
        return "an STL file that is cut off, or none"
    return None if b"endsolid" in tail.lower() else "text that does not end with 'endsolid'"


def _why_not_ply(file: Path) -> str | None:
    with file.open("rb") as stream:
        start = stream.read(LONGEST_HEADER)
        header, mark, _ = start.partition(b"end_header")
        if not start.startswith(b"ply") or not mark:
            return "no header of a PLY file"
        try:
            is_text, lines, least = _promised(header.decode("latin1"))
        except (KeyError, ValueError, IndexError) as error:
            return f"a header that cannot be understood ({error})"
        if not is_text:
            there = file.stat().st_size - len(header) - len(mark) - 1
            return None if there >= least else f"{there} bytes where {least} were promised at least"
        stream.seek(len(header) + len(mark))
        there = sum(1 for line in stream if line.strip())
        return None if there >= lines else f"{there} lines where {lines} were promised"


def _promised(header: str) -> tuple[bool, int, int]:
    """Whether the header promises text, in how many lines, or in how many bytes at least (lists of three)."""
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
