"""Compiled passes are kept on disk in a folder named by a digest of all the sources.

Numba's own check sees only a kernel's own file; a changed device function in another file would go unnoticed.  Where
the package's folder is read-only, the user's cache folder serves, and a temporary one where that is read-only too.
"""

import hashlib
import os
import shutil
import tempfile
import time
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from numba import config

from transport.engine.bundle import LANES

PACKAGE = Path(__file__).resolve().parents[1]
KERNELS = PACKAGE / "__kernels__"


def source_digest() -> str:
    """Digest of every source from which machine code is made."""
    digest = hashlib.sha256()
    for path in sorted(
        [*PACKAGE.glob("engine/*.py"), *PACKAGE.glob("physics/*.py"), PACKAGE / "compile/layout.py"]
    ):
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def kernel_folder() -> Path:
    """The folder for this build's machine code, made if need be."""
    name = f"{source_digest()}-{LANES}"
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    for root in (KERNELS, home / "transport" / "kernels"):
        with suppress(OSError):
            folder = root / name
            folder.mkdir(parents=True, exist_ok=True)
            folder.touch()
            with tempfile.TemporaryFile(dir=folder):
                pass
            _forget_others(root, keep=name.split("-")[0])
            return folder
    return Path(tempfile.mkdtemp(prefix="transport-kernels-"))


def _forget_others(root: Path, keep: str) -> None:
    """Remove machine code of other sources that nothing has used for a week."""
    long_ago = time.time() - 7 * 86400
    for folder in root.iterdir():
        with suppress(OSError):
            if not folder.name.startswith(keep) and folder.stat().st_mtime < long_ago:
                shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def cached_kernels():
    """Within this context Numba keeps machine code in `kernel_folder`; its setting is put back afterwards."""
    before, config.CACHE_DIR = config.CACHE_DIR, str(kernel_folder())
    try:
        yield
    finally:
        config.CACHE_DIR = before
