"""Passes driven by themselves on lanes that a test has filled: compiled, or as plain Python with numbers that it chooses."""

from __future__ import annotations

import ctypes

import numpy as np
from numba import config

from transport.compile import layout
from transport.engine.bodies import Pass
from transport.engine.bundle import LANES, empty_bundle
from transport.engine.registry import EMPTY_TABLE

PASS = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_uint64)
UNIT = np.array([2.0**-32, 2.0**-63])  # of the limbs of a weight


class Lanes:
    """A bundle of LANES particles with a ledger; fields are read and written by name."""

    def __init__(self, seed: int = 1, batch: int = 0, **fields) -> None:
        self.bundle = empty_bundle()
        self.ledger = np.zeros((layout.ABSORBED + 4, 4), np.int64)
        self.bundle["ledger"], self.bundle["ledger_words"] = self.ledger.ctypes.data, self.ledger.size
        self.bundle["seed_low"], self.bundle["batch"] = seed, batch
        self["history"], self["weight"], self["birth"] = np.arange(LANES), 1.0, 1.0
        self["uz"], self["mfp"], self["survival"] = 1.0, 1.0, 1.0
        for name, values in fields.items():
            self[name] = values

    def __getitem__(self, name: str) -> np.ndarray:
        return self.bundle[name][0][:LANES].copy()

    def __setitem__(self, name: str, values) -> None:
        self.bundle[name][0][:LANES] = values

    @property
    def directions(self) -> np.ndarray:
        """(LANES, 3)"""
        return np.stack([self["ux"], self["uy"], self["uz"]], axis=1)

    def gained(self, row: int) -> float:
        """What is in a row of the ledger [1]."""
        return float(self.ledger[row, :2] @ UNIT)

    def run(self, lane_pass: Pass, table: np.ndarray = EMPTY_TABLE, **values) -> Lanes:
        """Take a step; values: columns of its table."""
        table = layout.row(lane_pass.table, **values) if values else table
        if config.DISABLE_JIT:
            return self.run_plainly(lane_pass, table)
        PASS(lane_pass.entry)(self.bundle.ctypes.data, table.ctypes.data, 0, LANES)
        return self

    def run_plainly(self, lane_pass: Pass, table: np.ndarray = EMPTY_TABLE, **values) -> Lanes:
        """The same as plain Python, where what the pass calls can be replaced."""
        table = layout.row(lane_pass.table, **values) if values else table
        with np.errstate(over="ignore"):
            lane_pass.run_plainly(
                self.bundle.view(np.recarray)[0], table.reshape(1).view(np.recarray)[0], 0, LANES
            )
        return self
