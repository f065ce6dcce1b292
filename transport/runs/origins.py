"""Who did the batches of a run: the same sources on a like machine give the same bits, others agree statistically."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from itertools import chain
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Origin:
    """Who did batches: the version and the digest of the sources, the versions of what they stand on, the processor."""

    version: str
    sources: str
    versions: tuple[str, ...]
    machine: str


@cache
def this_origin() -> Origin:
    """These sources on this machine."""
    return Origin(_version(), sources_digest(), _versions(), _machine())


@cache
def sources_digest() -> str:
    """Digest of all sources of the package; what an installation compiled of them is left out."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        if "__kernels__" not in path.parts:
            digest.update(path.relative_to(PACKAGE).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def joined(*origins: Iterable[Origin]) -> tuple[Origin, ...]:
    """All of them, each once, the earlier ones first."""
    return tuple(dict.fromkeys(chain.from_iterable(origins)))


def doubts_of(origins: Iterable[Origin]) -> list[str]:
    """What a reader should know of a run that was not done by one program on one machine."""
    origins, found = list(origins), []
    sources = dict.fromkeys((origin.version, origin.sources) for origin in origins)
    if len(sources) > 1:
        told = ", ".join(f"{number} ({digest})" for number, digest in sources)
        found.append(f"its batches are of unlike sources of transport, {told}: what one did wrong is in it")
    unlike = dict.fromkeys((*origin.versions, origin.machine) for origin in origins)
    if len(unlike) > 1:
        told = "; ".join(", ".join(each) for each in unlike)
        found.append(f"its batches were done on unlike machines, {told}: the last digits may not repeat")
    return found


def _version() -> str:
    return _found("transport")


def _versions() -> tuple[str, ...]:
    """Of Python and of what the batches were done with."""
    return (f"Python {platform.python_version()}", *(f"{name} {_found(name)}" for name in ("numpy", "numba")))


def _found(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return "?"


def _machine() -> str:
    """Its processor, which decides how products and sums are rounded together."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return ", ".join((platform.system(), names[0] if names else platform.processor() or platform.machine()))
