"""Machine code is kept in a folder named by a digest of all sources; where the package is read-only, elsewhere."""

import os
import time
from pathlib import Path

import numba
import pytest

from transport.engine import cache

NOWHERE = Path("/proc/transport")  # where nobody can make a folder


@pytest.fixture(autouse=True)
def unremembered():
    """The folder is chosen once in a process."""
    cache.kernel_folder.cache_clear()
    yield
    cache.kernel_folder.cache_clear()


def test_kernels_lie_in_the_package(tmp_path, monkeypatch):
    assert cache.KERNELS.parent == Path(cache.__file__).parents[1]
    monkeypatch.setattr(cache, "KERNELS", tmp_path)
    assert cache.kernel_folder().is_relative_to(tmp_path)


def test_a_read_only_package_keeps_them_in_the_users_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "KERNELS", NOWHERE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.kernel_folder().is_relative_to(tmp_path)


@pytest.mark.parametrize("folder", ["site-packages", "dist-packages"])
def test_an_installed_package_leaves_nothing_in_its_folder(folder, tmp_path, monkeypatch):
    """Else a folder without sources stays when it is uninstalled, and hides an editable installation."""
    kernels = tmp_path / folder / "transport" / "__kernels__"
    monkeypatch.setattr(cache, "KERNELS", kernels)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert cache.kernel_folder().is_relative_to(tmp_path / "cache") and not kernels.parent.exists()


def test_a_read_only_home_keeps_them_in_a_temporary_folder(monkeypatch):
    monkeypatch.setattr(cache, "KERNELS", NOWHERE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(NOWHERE))
    assert cache.kernel_folder().is_dir()


def test_without_a_home_directory_they_are_kept_in_a_temporary_folder(monkeypatch):
    """As of a user of a container that no list of users has."""

    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(cache, "KERNELS", NOWHERE)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    assert cache.kernel_folder().is_dir()


@pytest.mark.parametrize(
    "file", ["physics/rays.py", "engine/tally.py", "engine/passes/optics.py", "compile/layout.py"]
)
def test_the_digest_follows_every_source(file, tmp_path, monkeypatch):
    """A changed device function in another file: what Numba's own check does not see."""
    for name in ("compile/layout.py", file):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("a = 1\n")
    monkeypatch.setattr(cache, "PACKAGE", tmp_path)
    before = cache.source_digest()
    assert cache.source_digest() == before
    (tmp_path / file).write_text("a = 2\n")
    assert cache.source_digest() != before


def test_code_of_other_sources_is_forgotten_after_a_week(tmp_path, monkeypatch):
    kernels = tmp_path / "__kernels__"
    monkeypatch.setattr(cache, "KERNELS", kernels)
    for name, age in (("0123456789abcdef-256", 8), ("fedcba9876543210-256", 1)):
        (kernels / name).mkdir(parents=True)
        os.utime(kernels / name, (time.time() - age * 86400,) * 2)
    folder = cache.kernel_folder()
    assert {path.name for path in kernels.iterdir()} == {folder.name, "fedcba9876543210-256"}


def test_numbas_own_setting_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "KERNELS", tmp_path)
    before = numba.config.CACHE_DIR
    with cache.cached_kernels():
        assert str(tmp_path) in numba.config.CACHE_DIR
    assert before == numba.config.CACHE_DIR
