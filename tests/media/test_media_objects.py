"""Media, phase functions and trackings as objects: what they hold, what they are equal to, what is refused; and what the guides promise."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
import re
import tracemalloc
from decimal import Decimal, getcontext

import numpy as np
import pytest

import transport as tp
from tests.refusals import assert_refused
from transport.cli.docs import GUIDES
from transport.compile.compiler import compile_scene
from transport.compile.grids import macro_cells
from transport.scene.bodies import MAX_BODIES
from transport.scene.media import BYTES_PER_VOXEL, canonical_medium

LAMP = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
BEAM = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), power=1.0))
CLEAR = tp.Transparent()
NODES, WEIGHTS = np.polynomial.legendre.leggauss(400)
TABLE = tp.Tabulated(mu=[-1, -0.3, 0.5, 0.9, 1], density=[1, 0, 2, 3, 30])
HG = tp.HenyeyGreenstein
CUBE = tp.Box(size=2)
CELLS = np.arange(24.0).reshape(2, 3, 4)
PHASES = {
    "isotropic": tp.Isotropic(),
    "forwards": HG(0.7),
    "backwards": HG(-0.6),
    "nearly isotropic": HG(1e-12),
    "rayleigh": tp.Rayleigh(),
    "table": TABLE,
    "mixture": tp.Mixture({HG(0.7): 0.25, HG(-0.6): 0.25, tp.Rayleigh(): 0.2, TABLE: 0.3}),
    "mixture with isotropic": tp.Mixture({tp.Isotropic(): 0.5, tp.Rayleigh(): 0.5}),
}  # fmt: skip


def integral(function):
    """Over all directions; by Gauss's rule between the points of TABLE, exact for its straight lines."""
    total = 0.0
    for low, high in zip(TABLE.mu[:-1], TABLE.mu[1:], strict=True):
        mu = low + (high - low) * (NODES + 1) / 2
        total += (high - low) / 2 * float(WEIGHTS @ function(mu))
    return 2 * math.pi * total


# ---- phase functions ----


@pytest.mark.parametrize("phase", PHASES.values(), ids=PHASES)
def test_densities_integrate_to_one_and_to_their_mean_cosine(phase):
    """To 1e-12: a wrong constant or a forgotten weight of a part is far beyond it."""
    assert integral(phase.density) == pytest.approx(1, rel=1e-12)
    assert integral(lambda mu: mu * phase.density(mu)) == pytest.approx(phase.g, rel=1e-12, abs=1e-14)


def test_densities_are_those_of_the_books():
    """Rayleigh's 3 (1 + mu^2) / (16 pi); Henyey and Greenstein's at mu = 0, (1 - g^2) / (4 pi (1 + g^2)^(3/2))."""
    mu = np.array([-1, 0.25, 1])
    assert tp.Rayleigh().density(mu) == pytest.approx(3 * (1 + mu * mu) / (16 * math.pi), rel=1e-15)
    assert HG(0.5).density(0.0) == pytest.approx(0.75 / (4 * math.pi * 1.25**1.5), rel=1e-15)
    assert tp.Isotropic().density(mu) == pytest.approx([1 / (4 * math.pi)] * 3)
    assert tp.Isotropic().density(np.zeros((2, 3))).shape == (2, 3) and tp.Isotropic().g == 0
    assert np.shape(tp.Isotropic().density(0.5)) == ()


@pytest.mark.parametrize("g", [0.999, -0.999, 1 - 1e-9, 1e-12, 0.0, -1e-12])
@pytest.mark.parametrize("mu", [1.0, -1.0, 1 - 1e-9, 1e-9 - 1, 0.3])
def test_henyey_and_greenstein_keep_their_digits(g, mu):
    """Against forty digits; 1 + g^2 - 2 g mu as it stands loses ten of them at g = 1 - 1e-9, mu = 1."""
    getcontext().prec = 40
    a, m = Decimal(g), Decimal(mu)
    chord = 1 + a * a - 2 * a * m
    exact = (1 - a * a) / (chord * chord.sqrt())
    assert HG(g).density(mu) * 4 * math.pi == pytest.approx(float(exact), rel=2e-14)


def test_a_table_is_normalised_whatever_its_unit():
    a = tp.Tabulated(mu=[-1, 0, 1], density=[1, 2, 4])
    b = tp.Tabulated(mu=np.array([-1, 0, 1]), density=np.array([1e300, 2e300, 4e300]))
    assert b.values == pytest.approx(a.values, rel=1e-15)
    # 2 pi (1.5 + 3) c = 1;  2 pi c (integral of mu (2 + mu) below 0, of mu (2 + 2 mu) above)
    assert a.values == pytest.approx(np.array([1, 2, 4]) / (9 * math.pi), rel=1e-15)
    assert a.g == pytest.approx((-1 + 1 / 3 + 1 + 2 / 3) / 4.5, rel=1e-15)
    assert a.density(0.5) == pytest.approx(3 / (9 * math.pi), rel=1e-15)


def test_a_table_never_changes_and_is_known_by_what_it_holds():
    mu, relative = np.array([-1.0, 0.0, 1.0]), np.array([1.0, 2.0, 4.0])
    one = tp.Tabulated(mu=mu, density=relative)
    same = tp.Tabulated(mu=mu, density=relative)
    mu[1] = 0.5
    other = tp.Tabulated(mu=mu, density=relative)
    assert one == same and hash(one) == hash(same) and one != other
    assert one.mu[1] == 0
    for made in (one, pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
        assert made == one and not made.mu.flags.writeable and not made.values.flags.writeable
    again = dataclasses.replace(one, density=one.density)
    assert again.values == pytest.approx(one.values, rel=1e-15)


def write(folder, text):
    file = folder / "mie.txt"
    file.write_text(text)
    return file


def test_a_table_is_read_from_a_file(tmp_path):
    """By angle or by cosine, rising or falling; 0 degrees is straight on."""
    by_cosine = tp.Tabulated(mu=[-1, 0, 0.5, 1], density=[1, 2, 3, 9])
    texts = {
        "degrees": "# angle, intensity\n0 90\n60 30  # a remark\n90 20\n180 10\n",
        "falling degrees": "180, 1\n90, 2\n60, 3\n0, 9\n",
        "cosines": "-1;1\n0;2\n0.5;3\n\n1;9\n",
        "falling cosines": "1 9\n0.5 3\n0 2\n-1 1",
    }
    for text in texts.values():
        read = tp.Tabulated.from_file(write(tmp_path, text))
        assert read.mu == pytest.approx(by_cosine.mu, abs=2e-16)
        assert read.values == pytest.approx(by_cosine.values, rel=1e-14)
        assert read.g > 0


def test_small_angles_of_a_file_stay_apart(tmp_path):
    """1e-6 degrees: cos(1.7e-8) is 1 in doubles to one digit, 1 - mu = 1.5e-16; 1e-5 degrees must not be lost."""
    read = tp.Tabulated.from_file(write(tmp_path, "0 3\n1e-5 2\n180 1\n"))
    assert 1 - read.mu[1] == pytest.approx(math.radians(1e-5) ** 2 / 2, rel=0.01)


def test_a_mixture_is_of_phases_or_of_materials():
    phases = tp.Mixture({HG(0.5): 0.75, tp.Rayleigh(): 0.25})
    assert phases == tp.Mixture({tp.Rayleigh(): 0.25, HG(0.5): 0.75}) and phases.is_phase
    assert phases.g == 0.375
    walls = tp.Mixture({tp.Mirror(): 0.5, tp.Black(): 0.5})
    assert not walls.is_phase and tp.Surface(CUBE, walls).material == walls
    tables = [tp.Tabulated(mu=[-1, 0, 1], density=[1, k, 1]) for k in (2, 3)]
    tables += [
        tp.Tabulated(mu=[-1, 0.5, 1], density=[1, 1, 1]),
        tp.Tabulated(mu=[-1, -0.5, 1], density=[1, 1, 1]),
    ]
    shares = dict(zip(tables, (0.1, 0.2, 0.3, 0.4), strict=True))
    assert tp.Mixture(shares) == tp.Mixture(dict(reversed(shares.items())))


# ---- media ----


def test_media_are_compared_by_value_and_those_that_act_alike_are_one():
    one, other = tp.Medium(1, 2, HG(0.5)), tp.Medium(absorption=1.0, scattering=2, phase=HG(g=0.5))
    assert one == other and hash(one) == hash(other) and one != tp.Medium(1, 2)
    assert one.extinction == 3 and one.albedo == 2 / 3
    assert tp.Medium().albedo == 0 and tp.Medium().phase == tp.Isotropic()
    assert tp.Vacuum() == tp.Vacuum() and tp.Vacuum().extinction == 0 and tp.Vacuum().index == 1
    assert repr(tp.Medium(1, index=1.5)) == "Medium(absorption=1.0, index=1.5)"
    assert eval(repr(one), vars(tp)) == one
    assert canonical_medium(tp.Medium()) == canonical_medium(tp.Medium(phase=tp.Rayleigh())) == tp.Vacuum()
    assert canonical_medium(tp.Medium(1, phase=tp.Rayleigh())) == tp.Medium(1)
    for how in (
        {"index": 1.5},
        {"emission": 1},
        {"absorption": 1, "scattering": 1, "phase": tp.Rayleigh()},
        {"scattering": 1},
    ):
        assert canonical_medium(tp.Medium(**how)) == tp.Medium(**how)


def test_a_grid_never_changes_and_is_known_by_what_it_holds():
    cells = CELLS.copy()
    one, same = (tp.Grid(box=CUBE, scattering=cells, phase=HG(0.5)) for _ in range(2))
    cells[1, 2, 3] = 0
    other = tp.Grid(box=CUBE, scattering=cells, phase=HG(0.5))
    assert one == same and hash(one) == hash(same)
    assert len({one, other, tp.Grid(box=CUBE, absorption=CELLS), tp.Grid(box=CUBE, scattering=CELLS)}) == 4
    assert one.scattering[1, 2, 3] == 23 and one.shape == (2, 3, 4)
    assert (
        (one.extinction == CELLS).all() and (one.albedo == (CELLS > 0)).all() and (one.absorption == 0).all()
    )
    for made in (one, pickle.loads(pickle.dumps(one)), copy.deepcopy(one), dataclasses.replace(one)):
        assert made == one
        assert not made.scattering.flags.writeable and not made.absorption.flags.writeable
    thick = dataclasses.replace(one, absorption=2)
    assert (thick.extinction == CELLS + 2).all() and thick != one


def test_what_a_grid_leaves_out_takes_no_memory():
    grid = tp.Grid(box=CUBE, scattering=np.ones((32, 32, 32), np.float32))
    assert grid.scattering.dtype == np.float64 and grid.scattering.nbytes == 8 * 32**3
    assert grid.absorption.strides == (0, 0, 0)


@pytest.mark.parametrize("number", [1.0, np.uint8(1)])
@pytest.mark.parametrize("names", [("absorption",), ("scattering",), ("absorption", "scattering")])
def test_more_voxels_than_fit_into_memory_are_refused_with_the_figure(number, names):
    values = dict.fromkeys(names, 1.0) | {names[0]: np.broadcast_to(number, (4000,) * 3)}
    first = "Grid: voxels must fit into memory, got shape (4000, 4000, 4000), which takes 3.07 TB"
    last = "of memory are left; use fewer voxels, or Medium(...) for a homogeneous medium"
    with pytest.raises(tp.SceneError, match=f"^{re.escape(first)}.*{re.escape(last)}$"):
        tp.Grid(box=CUBE, **values)


@pytest.mark.parametrize("names", [("absorption",), ("absorption", "scattering")])
def test_a_grid_takes_no_more_memory_than_documented(names):
    """The most that making it and compiling its scene take at a time, and its arena, beside the arrays given."""
    rng, n = np.random.default_rng(1), 100
    given = {name: rng.random((n, n, n)) for name in names}
    macro_cells.cache_clear()
    tracemalloc.start()
    grid = tp.Grid(box=CUBE, **given)
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    scene = tp.Scene(lamp, tp.Surface(CUBE, tp.Transparent(), inside=grid))
    plan = compile_scene(scene, tp.Tracking(absorption="analog"))
    assert plan.arena.memory.nbytes > 9 * n**3
    most = tracemalloc.get_traced_memory()[1] / n**3
    tracemalloc.stop()
    assert 0.5 * BYTES_PER_VOXEL < most < BYTES_PER_VOXEL


def test_a_surface_names_its_media_by_two_words():
    fog, mist = tp.Medium(1), tp.Medium(2)
    one = tp.Surface(CUBE, tp.Transparent(), inside=fog, outside=mist)
    other = tp.Surface(CUBE, tp.Transparent(), back=fog, front=mist)
    assert one == other and hash(one) == hash(other)
    assert (one.inside, one.back, one.outside, one.front) == (fog, fog, mist, mist)
    assert dataclasses.replace(one, name="a").back == fog
    assert tp.Surface(CUBE, tp.Black()).inside is None


def test_isotropic_without_an_amount_is_a_phase_only():
    for make in (
        lambda: tp.Source(tp.Point(), tp.Isotropic()),
        lambda: tp.Scene(tp.Source("a", tp.Isotropic()), tp.Surface(CUBE, tp.Black(), "a")),
        lambda: tp.Isotropic(speed=3),
    ):
        with pytest.raises(
            tp.SceneError, match="exactly one of power, intensity, energy must be given, got none"
        ):
            make()
    assert repr(tp.Isotropic()) == "Isotropic()" and tp.Isotropic() != tp.Isotropic(power=1)
    assert tp.Isotropic(power=1).given == "power"


# ---- refusals ----

REFUSALS = {
    "negative absorption": (lambda: tp.Medium(-1), ["Medium: absorption", "-1", "zero or positive"]),
    "infinite scattering": (lambda: tp.Medium(0, math.inf), ["Medium: scattering", "inf"]),
    "absorption in words": (lambda: tp.Medium("thick"), ["Medium: absorption", "'thick'"]),
    "overflow": (lambda: tp.Medium(1.7e308, 1.7e308), ["Medium: absorption + scattering", "finite"]),
    "no index": (lambda: tp.Medium(index=0), ["Medium: index", "positive", "0"]),
    "negative emission": (lambda: tp.Medium(emission=-1), ["Medium: emission", "-1"]),
    "phase class": (lambda: tp.Medium(phase=tp.Rayleigh), ["Medium: phase", "an instance", "Rayleigh"]),
    "phase as a number": (lambda: tp.Medium(phase=0.9), ["Medium: phase", "0.9", "HenyeyGreenstein"]),
    "lamp as a phase": (lambda: tp.Medium(phase=tp.Isotropic(power=1)), ["Medium: phase", "leave its amount out"]),
    "walls as a phase": (
        lambda: tp.Medium(phase=tp.Mixture({tp.Black(): 1})), ["Medium: phase", "mix phases, not materials"]
    ),
    "unknown": (lambda: tp.Medium(scatering=1), ["Medium: unknown parameter scatering", "did you mean 'scattering'?"]),
    "g of 1": (lambda: HG(1), ["HenyeyGreenstein: g", "below 1", "no scattering"]),
    "g nan": (lambda: HG(math.nan), ["HenyeyGreenstein: g", "nan"]),
    "g missing": (lambda: HG(), ["HenyeyGreenstein: g missing"]),
    "falling table": (lambda: tp.Tabulated(mu=[1, 0, -1], density=[1, 1, 1]), ["Tabulated: mu", "increase", "sort"]),
    "repeated cosine": (lambda: tp.Tabulated(mu=[-1, 0, 0, 1], density=[1] * 4), ["Tabulated: mu", "increase"]),
    "half a table": (lambda: tp.Tabulated(mu=[0, 1], density=[1, 1]), ["Tabulated: mu", "reach from -1 to 1", "0.0"]),
    "angles": (lambda: tp.Tabulated(mu=[0, 90, 180], density=[1, 1, 1]), ["Tabulated: mu", "reach from -1 to 1", "180"]),
    "short table": (lambda: tp.Tabulated(mu=[-1, 1], density=[1, 1, 1]), ["Tabulated: density", "as many", "2", "3"]),
    "empty table": (lambda: tp.Tabulated(mu=[-1, 1], density=[0, 0]), ["Tabulated: density", "zeros only"]),
    "negative table": (lambda: tp.Tabulated(mu=[-1, 1], density=[1, -2]), ["Tabulated: density", "-2.0 at 1"]),
    "table of text": (lambda: tp.Tabulated(mu=[-1, 1], density=["a", "b"]), ["Tabulated: density", "numbers", "'a'"]),
    "mixed mixture": (lambda: tp.Mixture({tp.Black(): 0.5, HG(0): 0.5}), ["Mixture: parts", "all phase functions"]),
    "mixture with a lamp": (
        lambda: tp.Mixture({tp.Isotropic(power=1): 0.5, HG(0): 0.5}), ["Mixture: parts", "Isotropic(power=1.0"]
    ),
    "half a mixture": (lambda: tp.Mixture({HG(0.5): 0.5}), ["Mixture: shares", "0.5", "divide them by their sum"]),
    "mean cosine of walls": (lambda: tp.Mixture({tp.Black(): 1}).g, ["Mixture: g", "materials"]),
    "phases on a wall": (lambda: tp.Surface(CUBE, tp.Mixture({HG(0): 1})), ["Surface: material", "Medium"]),
    "phases on a side": (
        lambda: tp.TwoSided(tp.Black(), tp.Mixture({HG(0): 1})), ["TwoSided: back", "phase functions belong"]
    ),
    "grid of numbers": (lambda: tp.Grid(box=CUBE, absorption=1), ["Grid: absorption or scattering", "Medium(...)"]),
    "grid of nothing": (lambda: tp.Grid(box=CUBE), ["Grid: absorption or scattering must be an array"]),
    "flat grid": (lambda: tp.Grid(box=CUBE, scattering=np.ones((2, 3))), ["Grid: scattering", "3 dim", "(2, 3)"]),
    "unlike arrays": (
        lambda: tp.Grid(box=CUBE, scattering=CELLS, absorption=CELLS[1:]), ["Grid: absorption and scattering", "(1, 3, 4)"]
    ),
    "hole in a grid": (
        lambda: tp.Grid(box=CUBE, scattering=np.where(CELLS == 6, math.nan, CELLS)), ["Grid: scattering", "nan", "(0, 1, 2)"]
    ),
    "negative grid": (lambda: tp.Grid(box=CUBE, scattering=-CELLS), ["Grid: scattering", "-1.0", "(0, 0, 1)"]),
    "negative number in a grid": (
        lambda: tp.Grid(box=CUBE, scattering=CELLS, absorption=-1), ["Grid: absorption", "-1", "zero or positive"]
    ),
    "complex grid": (lambda: tp.Grid(box=CUBE, scattering=CELLS + 1j), ["Grid: scattering", "array of numbers"]),
    "grid without a box": (lambda: tp.Grid(scattering=CELLS), ["Grid: box missing"]),
    "grid in a ball": (lambda: tp.Grid(box=tp.Sphere(radius=1), scattering=CELLS), ["Grid: box", "Sphere"]),
    "grid of light": (lambda: tp.Grid(box=CUBE, scattering=CELLS, emission=CELLS), ["Grid: emission", "one number"]),
    "medium in words": (lambda: tp.Surface(CUBE, CLEAR, inside="fog"), ["Surface: inside", "'fog'", "Medium("]),
    "medium class": (lambda: tp.Surface(CUBE, CLEAR, front=tp.Vacuum), ["Surface: front", "an instance", "Vacuum(...)"]),
    "two insides": (
        lambda: tp.Surface(CUBE, CLEAR, back=tp.Medium(1), inside=tp.Medium(2)), ["Surface: back and inside", "leave one of them out"]
    ),
    "analogue": (lambda: tp.Tracking(absorption="analogue"), ["Tracking: absorption", "did you mean 'analog'?"]),
    "no roulette": (lambda: tp.Tracking(roulette=0), ["Tracking: roulette", "never end"]),
    "forced by a number": (lambda: tp.Tracking(forced=1), ["Tracking: forced", "True or False"]),
    "split by a number": (lambda: tp.Tracking(splitting=3), ["Tracking: splitting", "Splitting("]),
    "split nowhere": (lambda: tp.Splitting(start=(0, 0, 1), end=(0, 0, 1), gain=2), ["Splitting: end", "start"]),
    "gain below 1": (lambda: tp.Splitting(start=(0, 0, 0), end=(0, 0, 1), gain=0.5), ["Splitting: gain", "0.5", "exchange"]),
}  # fmt: skip


@pytest.mark.parametrize(("make", "words"), REFUSALS.values(), ids=REFUSALS)
def test_wrong_input_is_refused_with_object_parameter_value_and_cure(make, words):
    assert_refused(make, words)


FILES = {
    "radians": ("0 1\n1.5 1\n3.14159 1\n", ["goes from 0 to 3.14159", "degrees from 0 to 180"]),
    "half the angles": ("0 1\n90 1\n", ["goes from 0 to 90", "both ends"]),
    "three columns": ("0 1 1\n180 1 1\n", ["line 1", "two numbers", "'0 1 1'"]),
    "a heading": ("# mie\nangle S11\n0 1\n180 1\n", ["line 2", "'angle S11'", "#"]),
    "nan": ("0 1\n90 nan\n180 1\n", ["line 2", "nan"]),
    "nothing": ("# nothing\n", ["two lines of numbers", "got 0"]),
    "an angle twice": ("0 1\n90 1\n90 2\n180 1\n", ["Tabulated: mu", "increase"]),
}


@pytest.mark.parametrize(("text", "words"), FILES.values(), ids=FILES)
def test_files_that_are_no_table_are_refused(text, words, tmp_path):
    with pytest.raises(tp.SceneError) as caught:
        tp.Tabulated.from_file(write(tmp_path, text))
    assert [word for word in words if word not in str(caught.value)] == [], caught.value
    with pytest.raises(tp.SceneError, match="cannot be read"):
        tp.Tabulated.from_file(tmp_path / "none.txt")


# ---- promises of the guides on media and surfaces ----

SAID = " ".join(
    " ".join((GUIDES / name).read_text(encoding="utf-8").split()) for name in ("media.md", "surfaces.md")
)


def run(scene, particles=320):
    return tp.simulate(scene, particles, seed=1, threads=1, progress=False)


def refusal(make) -> str:
    with pytest.raises(tp.SceneError) as refused:
        make()
    return str(refused.value)


@pytest.mark.parametrize("is_empty_below", [True, False])
def test_layers_of_unlike_index_end_in_a_vacuum_that_is_named(is_empty_below):
    """As the guide says it: what lies below the last plane is inside of the first one's body."""
    media = [None, *(tp.Medium(absorption=1.0, index=index) for index in (1.5, 1.37, 1.44))]
    media.append(tp.Vacuum() if is_empty_below else None)
    indices = [1, 1.5, 1.37, 1.44, 1]
    planes = [
        tp.Surface(
            tp.Plane(center=(0, 0, -z)),
            tp.Dielectric(indices[z + 1], indices[z]),
            front=media[z],
            back=media[z + 1],
        )
        for z in range(4)
    ]
    assert "Below the last layer say `back=Vacuum()`" in SAID
    if is_empty_below:
        assert run(tp.Scene(BEAM, planes)).ledger["lost"].value == 0
    else:
        assert "write back=Vacuum()" in refusal(lambda: tp.Scene(BEAM, planes))


def test_the_guide_names_the_largest_number_of_bodies_and_the_cure():
    assert f"at most {MAX_BODIES} bodies" in SAID
    layers = [
        tp.Surface(tp.Slab(center=(0, 0, -z), thickness=1), tp.Transparent(), inside=tp.Medium(0.1 * z))
        for z in range(1, MAX_BODIES + 2)
    ]
    assert f"at most {MAX_BODIES} bodies" in refusal(lambda: tp.Scene(LAMP, layers))
    grid = tp.Grid(box=tp.Box(size=(1e4, 1e4, 63)), absorption=np.linspace(1e-3, 1e-2, 63)[None, None])
    beam = tp.Source(tp.Point(position=(3, 2, 40)), tp.Beam((0, 0, -1), power=1.0))
    through = run(tp.Scene(beam, tp.Surface(grid.box, tp.Transparent(), inside=grid))).ledger["escaped"]
    assert through.value == pytest.approx(math.exp(-63 * 5.5e-3), rel=1e-9)


def test_glass_with_a_clock_needs_its_medium():
    """Two metres of index 1.5 on four of way: all that comes straight through arrives at 5 m / c."""
    assert "With a clock a `Dielectric` needs its medium" in SAID
    slab, glass = tp.Slab(center=(0, 0, -1), thickness=2.0), tp.Dielectric(1.5)
    flash = tp.Source(tp.Point(position=(0, 0, 1)), tp.Beam((0, 0, -1), energy=1.0), pulse=tp.Instant(0.0))
    metre = 1 / 299792458.0  # [s]
    times = [0, 4.99 * metre, 5.01 * metre, 8 * metre]
    meter = tp.Detector(tp.Plane(center=(0, 0, -3)), "meter", times=times)

    def scene(inside):
        return tp.Scene(flash, tp.Surface(slab, glass, inside=inside), meter, duration=8 * metre)

    assert "name its medium, inside=Medium(index=1.5)" in refusal(lambda: scene(None))
    early, due, _ = run(scene(tp.Medium(index=1.5)), particles=3200)["meter"].energy_in.value
    assert early == 0 and due == pytest.approx(0.96**2, abs=0.02)


def test_a_point_may_lie_on_what_is_transparent():
    """exp(-k r) / (4 pi r^2) at the face of a ball of fog, exactly; on a black ball it is refused."""
    ball = tp.Sphere(radius=1.0)
    there = tp.PointDetector((0, 0, 1), "there")
    fog = tp.Surface(ball, tp.Transparent(), inside=tp.Medium(absorption=0.5))
    seen = run(tp.Scene(LAMP, fog, there))["there"].fluence_rate
    assert seen.value == pytest.approx(math.exp(-0.5) / (4 * math.pi), rel=1e-12)
    assert "position must not lie on" in refusal(lambda: tp.Scene(LAMP, tp.Surface(ball, tp.Black()), there))
    assert "On a Transparent surface it may lie" in " ".join(tp.PointDetector.__doc__.split())


def test_events_are_scatterings_too():
    slab = tp.Slab(center=(0, 0, -0.5), thickness=1.0)
    below = tp.Plane(center=(0, 0, -2))
    fog = tp.Surface(slab, tp.Transparent(), inside=tp.Medium(scattering=1.0, absorption=0.1))
    parts = {"straight": 0, "once": 1, "more": (2, math.inf)}
    meters = [tp.Detector(below, name, events=events) for name, events in parts.items()]
    result = run(tp.Scene(BEAM, fog, [*meters, tp.Detector(below, "all")]), particles=3200)
    fluxes = [result[name].flux_in.value for name in parts]
    assert fluxes[0] == pytest.approx(math.exp(-1.1), rel=0.1) and min(fluxes) > 0.05
    assert sum(fluxes) == pytest.approx(result["all"].flux_in.value, rel=1e-12)
    assert "scatterings" in refusal(lambda: tp.Detector(below, "m", events=-1))
    assert "scattered" in tp.Detector.__doc__


def balls(*media):
    """Balls in a row, named "b0", "b1", ..., each with a medium, in the light of a lamp."""
    lamp = tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=1.0))
    walls = [
        tp.Surface(tp.Sphere(center=(2 * k, 0, 0), radius=0.5), tp.Transparent(), f"b{k}", inside=medium)
        for k, medium in enumerate(media)
    ]
    return tp.Scene(lamp, walls, medium=tp.Medium(absorption=0.1))


def test_media_that_differ_have_names_that_differ():
    tissue = tp.Medium(absorption=1.0, name="tissue")
    assert len(balls(tissue, tissue).surfaces) == 2
    with pytest.raises(tp.SceneError, match="media that differ must not have one name, got 'tissue' twice"):
        balls(tissue, tp.Medium(absorption=2.0, name="tissue"))


def test_a_medium_named_like_an_entry_of_the_balance_has_one_of_its_own():
    """ "inside b1" is what the balance calls the medium without a name in the second ball, "medium" the one around."""
    media = (tp.Medium(absorption=1.0, name="inside b1"), tp.Medium(absorption=2.0))
    ledger = tp.simulate(balls(*media), 1000, seed=1, progress=False).ledger
    assert list(ledger.absorbed_by)[-3:] == ["medium", "medium inside b1", "inside b1"]
    assert ledger["absorbed"].value == pytest.approx(sum(each.value for each in ledger.absorbed_by.values()))


def test_a_surface_that_cannot_absorb_surely_absorbs_nothing():
    lamp = tp.Source(tp.Point(position=(0, 0, 2)), tp.Isotropic(power=1.0))
    ball = tp.Surface(tp.Sphere(radius=0.5), tp.Dielectric(1.5), "ball")
    floor = tp.Surface(tp.Rectangle(center=(0, 0, -1), width=2, height=2), tp.Diffuse(0.5), "floor")
    ledger = tp.simulate(tp.Scene(lamp, [ball, floor]), 1000, seed=1, progress=False).ledger
    assert ledger.absorbed_by["ball"].exact and "by ball" not in str(ledger)
    assert not ledger.absorbed_by["floor"].exact
