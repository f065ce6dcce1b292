"""Random stuff: materials of every kind, and media that absorb and scatter, evenly or in voxels."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

import transport as tp
from transport.scene.materials import Material
from transport.scene.phase_functions import Phase

LEAST = 1e-4  # that turbid glass absorbs, of what crosses it
OUTLINE = tp.Disk | tp.Rectangle  # shapes that a thin lens may have


def shares(most: float = 1.0) -> st.SearchStrategy[float]:
    """Shares up to `most`, with both ends."""
    return st.one_of(st.sampled_from([0.0, 1.0, 0.5]), st.floats(0.0, 1.0)).map(lambda x: x * most)


@st.composite
def split(draw, most: float) -> tuple[float, float]:
    """Two shares of together `most` at the most: what is reflected, and what is let through."""
    first = draw(shares(most))
    second = draw(st.sampled_from([0.0, 0.5, 1.0])) * (most - first)
    return first, second


def plain(most: float = 1.0) -> st.SearchStrategy[Material]:
    """Black, diffuse, mirroring and glossy materials that return or let through `most` at the most."""
    return st.one_of(
        st.just(tp.Black()),
        split(most).map(lambda pair: tp.Diffuse(*pair)),
        split(most).map(lambda pair: tp.Mirror(*pair)),
        st.builds(tp.Glossy, st.sampled_from([0.02, 0.3, 1.0]), shares(most)),
    )


@st.composite
def mixtures(draw, most: float = 1.0) -> Material:
    """Two or three plain materials by shares."""
    parts = draw(st.lists(plain(most), min_size=2, max_size=3, unique_by=repr))
    return tp.Mixture({part: 1 / len(parts) for part in parts})


def opaque(most: float = 1.0) -> st.SearchStrategy[Material]:
    """Materials of any kind but glass, lenses and Transparent, alike or unlike on both sides."""
    one = st.one_of(plain(most), plain(most), mixtures(most))
    return st.one_of(one, one, one, st.builds(tp.TwoSided, front=one, back=one))


@st.composite
def of_shape(draw, shape, light: bool = True) -> Material:
    """A material that goes with the shape: a lens on a disk, glass on a closed one; none of these for particles."""
    choices = [opaque(), opaque(), opaque(), st.just(tp.Transparent())]
    if light and shape.is_closed:
        choices += [st.builds(tp.Dielectric, indices())] * 2
    if light and isinstance(shape, OUTLINE) and getattr(shape, "hole", None) is None:
        choices.append(st.builds(tp.ThinLens, st.sampled_from([0.5, -0.5, 3.0, 0.1])))
    return draw(st.one_of(choices))


def indices() -> st.SearchStrategy[float]:
    """Indices of refraction, nearly 1 as well, and below."""
    return st.sampled_from([1.5, 1.33, 1.0 + 1e-9, 2.5, 0.8])


def phases() -> st.SearchStrategy[Phase]:
    """Phase functions: isotropic, forwards, backwards, Rayleigh's, of a table, mixed."""
    # Of such values that to normalise them twice changes no digit: the scene as written is the same scene then.
    table = tp.Tabulated(mu=(-1, 0, 0.9, 1), density=(0.25, 0, 1, 8))
    mixed = tp.Mixture({tp.Rayleigh(): 0.5, tp.HenyeyGreenstein(-0.5): 0.5})
    one = [tp.Isotropic(), tp.HenyeyGreenstein(0.8), tp.HenyeyGreenstein(-0.3), tp.Rayleigh(), table, mixed]
    return st.sampled_from(one)


@st.composite
def media(draw, size: float, index: float = 1.0, most: float = 0.95) -> tp.Medium:
    """An even medium of optical depths from 1e-6 to 10 across `size`, of an albedo of `most` at the most."""
    depth = draw(st.sampled_from([1e-6, 0.1, 1.0, 1.0, 10.0]))
    albedo = draw(st.sampled_from([0.0, 0.5, 1.0])) * most
    extinction = depth / size
    phase = draw(phases()) if albedo else tp.Isotropic()
    return tp.Medium(extinction * (1 - albedo), extinction * albedo, phase=phase, index=index)


@st.composite
def turbid(draw, size: float, index: float, most: float = 0.95) -> tp.Medium:
    """What fills glass: it absorbs LEAST of what crosses it at least.

    Light that is scattered into directions in which glass never lets it out stays until it is absorbed: with 1e-7 of it a crossing,
    a history goes through ten million crossings, as it should, and a scene of them is a matter of minutes.
    """
    medium = draw(media(size, index, most))
    absorption = max(medium.absorption, LEAST / size)
    return tp.Medium(absorption, medium.scattering, phase=medium.phase, index=index)


@st.composite
def grids(draw, box: tp.Box) -> tp.Grid:
    """Voxels with some empty ones, of optical depths up to 3 each."""
    cells = draw(st.sampled_from([(1, 2, 3), (2, 2, 2), (4, 1, 1)]))
    numbers = np.random.Generator(np.random.Philox(draw(st.integers(0, 99))))
    extinction = numbers.choice([0.0, 0.3, 1.0, 3.0], size=cells) / max(box.size)
    albedo = draw(st.sampled_from([0.0, 0.5, 0.95]))
    if not extinction.any():
        extinction = extinction + 1 / max(box.size)
    phase = draw(phases()) if albedo else tp.Isotropic()
    return tp.Grid(box=box, absorption=extinction * (1 - albedo), scattering=extinction * albedo, phase=phase)
