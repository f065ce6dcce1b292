"""Arrays of estimates: names, edges, sums and broadcasting; elements and arrays agree."""

import math
import sys

import numpy as np
import pytest

from tests.synthetic import EDGES, EVEN_RUN, RUN, grid, noisy
from transport.statistics.estimates import Estimate, EstimateArray
from transport.statistics.replicates import Batches
from transport.validation import SceneError, optional_packages


def test_elements_and_slices_keep_names_and_edges():
    L = grid(1)
    assert (L.dims, L.shape, len(L)) == (("mu", "phi"), (4, 3), 4)
    assert isinstance(L[1, 2], Estimate)
    assert L[1, 2].value == L.value[1, 2]
    assert L[-1, 0].error == L.error[3, 0]
    assert (L[1].dims, L[..., 1].dims, L[:, 1:].shape) == (("phi",), ("mu",), (4, 2))
    np.testing.assert_array_equal(L[1:3].coords["mu"], EDGES["mu"][1:4])
    assert [row.dims for row in L] == [("phi",)] * 4
    with pytest.raises(IndexError, match="index 7 is out of bounds for axis 0 with 4 bins"):
        L[7]
    with pytest.raises(IndexError, match="index -4 is out of bounds for axis 1 with 3 bins"):
        L[..., -4]
    for bad in (4, (0, 0, 0), [0, 1], slice(None, None, 2), None, True):
        with pytest.raises(IndexError):
            L[bad]


def test_sums_over_bins_keep_correlations():
    values = np.random.default_rng(2).multinomial(1000, [0.25] * 4, size=32) / 1000.0
    shares = EstimateArray(values, EVEN_RUN, "1", ("mu",), {"mu": EDGES["mu"]})
    assert shares.sum().value == pytest.approx(1.0, rel=1e-14)
    assert shares.sum().error < 1e-15 or math.isnan(shares.sum().error)
    L = grid(1)
    assert L.sum("mu").dims == ("phi",)
    assert L.sum().error == pytest.approx(Estimate(L.values.sum(axis=(1, 2)), RUN, L.unit).error, rel=1e-12)
    assert sum(L.sum("phi")).value == pytest.approx(L.sum().value, rel=1e-14)
    assert L.sum(("phi", "mu")).value == pytest.approx(L.sum().value, rel=1e-14)
    assert (L.sum(("phi",)).dims, L.sum(()).dims) == (("mu",), ("mu", "phi"))
    with pytest.raises(ValueError, match="no axis 'theta'"):
        L.sum("theta")


def test_means_over_bins_keep_correlations():
    L = grid(1)
    assert L.mean().value == pytest.approx(L.value.mean(), rel=1e-14)
    assert L.mean().error == pytest.approx(Estimate(L.values.mean(axis=(1, 2)), RUN, L.unit).error, rel=1e-12)
    np.testing.assert_allclose(L.mean("phi").value, L.value.mean(axis=1), rtol=1e-14)
    assert L.mean(("mu", "phi")).value == L.mean().value
    with pytest.raises(ValueError, match="mean: no axis 'theta'"):
        L.mean("theta")


def test_numpy_takes_the_values_but_where_errors_would_be_lost():
    L = grid(1)
    for function, cure in ((np.sum, r"\.sum\(\)"), (np.mean, r"\.mean\(\)"), (np.average, r"\.mean\(\)")):
        with pytest.raises(TypeError, match=cure):
            function(L)
    np.testing.assert_array_equal(np.concatenate([L, L]), np.concatenate([L.value, L.value]))
    np.testing.assert_array_equal(np.atleast_2d(L), L.value)
    assert np.allclose(a=L, b=L.value)


def test_an_array_can_be_plotted():
    figure = pytest.importorskip("matplotlib.figure")
    L = grid(1)
    axes = figure.Figure().subplots()
    for given, drawn in ((L[:, 0], L.value[:, 0]), (L[1, 1], L.value[1, 1]), (list(L[0]), L.value[0])):
        (line,) = axes.plot(given, "o")
        np.testing.assert_array_equal(line.get_ydata(orig=False), np.atleast_1d(drawn))
    axes.errorbar(range(4), L[:, 1], yerr=L[:, 1].error)
    axes.stairs(L[:, 1], L.coords["mu"])
    axes.imshow(L)
    axes.bar(range(4), L[:, 2])


def test_an_array_of_one_bin_is_a_number():
    L = grid(1)
    assert float(L[1:2, 1:2]) == L.value[1, 1]
    with pytest.raises(TypeError, match=r"one bin.*\(4, 3\)"):
        float(L)


def test_arithmetic_of_arrays_broadcasts_by_name_and_by_shape():
    L, solid_angle = grid(1), np.linspace(0.1, 0.3, 3)
    for product in (L * solid_angle, solid_angle * L):
        np.testing.assert_allclose(product.value, L.value * solid_angle, rtol=1e-14)
        np.testing.assert_allclose(product.error, L.error * solid_angle, rtol=1e-12)
    assert (np.float64(2) * L).value[0, 0] == 2 * L.value[0, 0]
    by_name = L / L.sum("mu")
    assert by_name.dims == ("mu", "phi")
    np.testing.assert_allclose(by_name.sum("mu").value, 1, rtol=1e-3)
    across = L.sum("phi") * L.sum("mu")
    assert across.dims == ("mu", "phi")
    assert (noisy(2, 0.1, 5) * L)[1, 1].error > L[1, 1].error
    with pytest.raises(ValueError, match="does not fit"):
        L * np.ones(4)
    with pytest.raises(ValueError, match="bins along 'mu'"):
        L[1:] + L[:-1]


def test_an_element_has_the_numbers_that_it_had_in_the_array():
    L, flux = grid(1), noisy(2, 0.1, 5)
    ratio = L / flux
    alone = L[2, 1] / flux
    assert ratio[2, 1].value == pytest.approx(alone.value, rel=1e-14)
    # Of two uncertain numbers the error is that of the batches; of bins their neighbours are asked as well.
    assert ratio._replicates.error[2, 1] == pytest.approx(alone.error, rel=1e-12)


def test_bins_without_a_score_say_so():
    values = np.random.default_rng(1).poisson(0.05, size=(32, 4, 3)).astype(float)
    values[:, 2, 1] = 0
    L = EstimateArray(values, RUN, "W", ("mu", "phi"), EDGES, counts=values.sum(axis=0))
    assert np.isnan(L.error[2, 1])
    assert L.reason[2, 1] == "no score"
    assert L[2, 1].reason == "no score"
    assert L.sum("phi")[2].reason is None
    assert "error unknown in" in repr(L)


def test_arrays_convert_to_numpy_and_xarray():
    L = grid(1)
    np.testing.assert_array_equal(np.asarray(L), L.value)
    data = L.to_xarray()
    assert data["value"].dims == ("mu", "phi")
    assert data.attrs["units"] == "W m^-2 sr^-1"
    np.testing.assert_allclose(data["mu"], [0.125, 0.375, 0.625, 0.875])
    np.testing.assert_array_equal(data["phi_low"], EDGES["phi"][:-1])
    np.testing.assert_array_equal(data["phi_high"], EDGES["phi"][1:])
    assert (data["phi"].attrs, data["mu_low"].attrs) == ({"units": "rad"}, {"units": "1"})
    np.testing.assert_array_equal(data["error"], L.error)
    table = data.to_dataframe()
    assert (len(table), set(table.columns)) == (
        12,
        {"value", "error", "doubtful", "mu_low", "mu_high", "phi_low", "phi_high"},
    )
    assert len(repr(L)) < 120


def test_a_repr_shows_the_range_of_what_is_known():
    shares = grid(1, unit="1")
    assert "inf" not in repr(shares) and " 1," not in repr(shares)
    values = np.array(shares.values)
    values[:, 2, 1] = np.nan
    partly = EstimateArray(values, RUN, "W", ("mu", "phi"), EDGES)
    assert f"{np.nanmin(partly.value):.4g} to {np.nanmax(partly.value):.4g} W, median" in repr(partly)
    assert "error unknown in 1 of 12" in repr(partly)
    assert partly.reason[2, 1] == "undefined: not finite"
    nowhere = EstimateArray(np.full_like(values, np.nan), RUN, "W", ("mu", "phi"), EDGES)
    assert "error unknown in 12 of 12" in repr(nowhere)


def test_malformed_arrays_are_refused():
    values = np.ones((32, 4))
    with pytest.raises(ValueError, match="5 edges"):
        EstimateArray(values, RUN, "W", ("mu",), {"mu": np.arange(4)})
    with pytest.raises(ValueError, match="must match"):
        EstimateArray(values, RUN, "W", ("mu", "phi"), EDGES)
    with pytest.raises(ValueError, match="31 batch values"):
        Estimate(np.ones(31), RUN, "W")
    with pytest.raises(ValueError, match="positive whole"):
        Batches([3, 0])


def test_without_xarray_the_command_that_installs_it_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(SceneError, match=r"to_xarray: xarray is not installed; pip install '\.\[files\]'"):
        grid(1).to_xarray()


def test_a_missing_module_of_no_extra_is_not_explained_away():
    with pytest.raises(ModuleNotFoundError), optional_packages("here"):
        import no_such_module  # noqa: F401
