"""Provenance of batches: equal sources on like machines give equal bits, others agree statistically."""

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
    """Provenance of batches: version and digest of the sources, versions of libraries, processor."""

    version: str
    sources: str
    versions: tuple[str, ...]
    machine: str


@cache
def this_origin() -> Origin:
    """Return the provenance of batches of this process."""
    libraries = (f"{name} {_installed_version(name)}" for name in ("numpy", "numba"))
    versions = f"Python {platform.python_version()}", *libraries
    return Origin(_installed_version("transport"), sources_digest(), versions, _machine())


@cache
def sources_digest() -> str:
    """Return a digest of all sources of the package, without compiled kernels."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        if "__kernels__" not in path.parts:
            digest.update(path.relative_to(PACKAGE).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def distinct_origins(*origins: Iterable[Origin]) -> tuple[Origin, ...]:
    """Return all distinct origins in order of appearance."""
    return tuple(dict.fromkeys(chain.from_iterable(origins)))


def origin_warnings(origins: Iterable[Origin]) -> list[str]:
    """Return findings about a run whose batches come from different sources or machines, as sentences."""
    origins, found = list(origins), []
    sources = dict.fromkeys((origin.version, origin.sources) for origin in origins)
    if len(sources) > 1:
        text = ", ".join(f"{number} ({digest})" for number, digest in sources)
        what = f"its batches come from different sources of transport, {text}"
        found.append(f"{what}: a bug in one affects the result")
    unlike = dict.fromkeys((*origin.versions, origin.machine) for origin in origins)
    if len(unlike) > 1:
        text = "; ".join(", ".join(each) for each in unlike)
        found.append(f"its batches come from different machines, {text}: the last digits may not repeat")
    return found


def _installed_version(name: str) -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(name)
    except PackageNotFoundError:
        return "?"


def _machine() -> str:
    """Return the system and the processor, which decides on fused multiply-add (its rounding)."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return ", ".join((platform.system(), names[0] if names else platform.processor() or platform.machine()))
