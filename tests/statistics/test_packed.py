"""Columns of very many rows, of which few have scored: packed they are the same numbers in few bytes, in memory or aside in a file."""

import pickle
import tempfile
import tracemalloc

import numpy as np
import pytest

from transport.statistics import chunked, packed

rng = np.random.default_rng(1)
COLUMNS = {  # and the unit of most of their numbers
    "nothing": (np.zeros(5001), 1),
    "counts": (rng.poisson(0.5, 5001), 1),
    "counts, some of them huge": (np.where(rng.random(5001) < 0.01, 1 << 50, rng.poisson(0.5, 5001)), 1),
    "weights": (rng.random(5001) * (rng.random(5001) < 0.3), 1),
    "slants, some of them grazing": (np.floor(rng.pareto(0.5, 5001) * 1e6) * 2.0**-22, 2.0**-22),
    "momenta": (rng.standard_normal(5001), 1),
    "one": (np.eye(1, 5001, 3000).ravel(), 1),
    "a whole page": (np.ones(4096), 1),
}


@pytest.mark.parametrize("name", COLUMNS)
def test_a_packed_column_is_what_it_stands_for(name, monkeypatch):
    monkeypatch.setattr(packed, "CHUNK_ROWS", packed.PAGE)
    rows, unit = COLUMNS[name]
    column = packed.pack(lambda first, past: rows[first:past], len(rows), unit)
    assert column[:].dtype == rows.dtype
    np.testing.assert_array_equal(column[:], rows)
    for first, past in np.sort(rng.integers(0, len(rows) + 1, (20, 2))):
        np.testing.assert_array_equal(column[first:past], rows[first:past])
    np.testing.assert_array_equal((column + column)[:], rows + rows)
    assert (column.max(), len(column)) == (rows.max(), len(rows))


def test_numbers_are_kept_in_few_bytes():
    sizes = {
        name: packed.pack(lambda a, b, rows=rows: rows[a:b], len(rows), unit).nbytes / rows.nbytes
        for name, (rows, unit) in COLUMNS.items()
    }
    assert sizes["counts"] < 0.1 and sizes["counts, some of them huge"] < 0.13
    assert sizes["slants, some of them grazing"] < 0.65 and sizes["nothing"] == 0


@pytest.fixture
def all_aside(monkeypatch):
    """Numbers are put aside, however few."""
    if not chunked.can_map_files():
        pytest.skip("temporary files lie in memory here")
    monkeypatch.setattr(chunked, "MIN_MAPPED_BYTES", 1)


def test_numbers_aside_are_the_same_also_in_another_process(all_aside):
    rows = COLUMNS["weights"][0]
    column = packed.pack(lambda first, past: rows[first:past], len(rows))
    sent = pickle.loads(pickle.dumps(column))
    for found in (column, column + packed.pack(lambda a, b: 0 * rows[a:b], len(rows)), sent):
        assert isinstance(found.numbers, np.memmap) and found.numbers._mmap is not None
        np.testing.assert_array_equal(found[:], rows)
    assert chunked.to_memmap(column.numbers) is column.numbers


@pytest.mark.skipif(not chunked.can_map_files(), reason="temporary files lie in memory here")
def test_a_column_of_many_weights_takes_less_than_a_byte_a_row():
    rows = rng.random(3_000_000)
    tracemalloc.start()
    column = packed.pack(lambda first, past: rows[first:past], len(rows))
    kept = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert kept < 0.5 * len(rows) and column.nbytes > 8 * len(rows)
    np.testing.assert_array_equal(column[1_000_000:1_500_000], rows[1_000_000:1_500_000])


def test_numbers_stay_in_memory_where_the_disk_is_full_or_files_lie_there(all_aside, tmp_path, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    rows = rng.random(100)
    with monkeypatch.context() as patched:
        patched.setattr(chunked.os, "posix_fallocate", full)
        assert chunked.to_memmap(rows) is rows and not isinstance(chunked.empty_memmap(3, float), np.memmap)
    assert isinstance(chunked.empty_memmap(3, float), np.memmap)
    (tmp_path / "mounts").write_text(f"disk / ext4 rw 0 0\ntmpfs {tmp_path / 'fast'} tmpfs rw 0 0\n")
    monkeypatch.setattr(chunked, "MOUNTS", tmp_path / "mounts")
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path / "fast/of/a/job"))
    assert (chunked.can_map_files(), chunked.free_disk_bytes()) == (False, 0)
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    assert chunked.can_map_files() and chunked.free_disk_bytes() > 0
