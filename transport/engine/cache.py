"""On-disk cache of compiled passes, in a folder named by a digest of all sources.

Numba's own check sees only the file of a kernel and would miss a changed device function in another file. A
clone keeps machine code in its package folder. An installed or read-only package keeps it in the user's
cache folder, because files that pip does not know would outlive the package; if that is read-only too, in a
temporary folder.
"""

import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

import numpy as np
from numba import config

from transport.compile import layout
from transport.engine.bundle import LANES

PACKAGE = Path(__file__).resolve().parents[1]
KERNELS = PACKAGE / "__kernels__"
INSTALLED = ("site-packages", "dist-packages")  # folders that pip installs into


def source_digest() -> str:
    """Return the first 16 hex digits of the SHA-256 of every source and record type that is compiled."""
    digest = hashlib.sha256()
    kinds = {name: kind.descr for name, kind in vars(layout).items() if isinstance(kind, np.dtype)}
    digest.update(repr(kinds).encode())
    for path in sorted(
        [*PACKAGE.glob("engine/**/*.py"), *PACKAGE.glob("physics/*.py"), PACKAGE / "compile/layout.py"]
    ):
        digest.update(path.relative_to(PACKAGE).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def kernel_folder() -> Path:
    """Return the cache folder of this build, created if necessary."""
    name = f"{source_digest()}-{LANES}"
    for root in _roots():
        with suppress(OSError):  # read-only
            folder = root / name
            folder.mkdir(parents=True, exist_ok=True)
            folder.touch()
            # Test that the folder is writable.
            with tempfile.TemporaryFile(dir=folder):
                pass
            _remove_stale(root, keep=name.split("-")[0])
            return folder
    return Path(tempfile.mkdtemp(prefix="transport-kernels-"))


def _roots() -> Iterator[Path]:
    """Yield the folder of a clone, and the user's cache folder."""
    if KERNELS.parents[1].name not in INSTALLED:
        yield KERNELS
    with suppress(RuntimeError):  # no home directory
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "transport" / "kernels"


def _remove_stale(root: Path, keep: str) -> None:
    """Remove machine code of other sources that has not been used for a week."""
    long_ago = time.time() - 7 * 86400
    for folder in root.iterdir():
        with suppress(OSError):
            if not folder.name.startswith(keep) and folder.stat().st_mtime < long_ago:
                shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def cached_kernels():
    """Context in which Numba caches machine code in `kernel_folder`; restores its setting afterwards."""
    before, config.CACHE_DIR = config.CACHE_DIR, str(kernel_folder())
    try:
        yield
    finally:
        config.CACHE_DIR = before
