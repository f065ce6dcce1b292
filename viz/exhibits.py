"""The gallery's general figures: what each shows, whose result it is drawn from, and how; nothing is run here.  And what sketches of several experiments share.

An exhibit is of an experiment's scene with some parameters, or of the showroom, where `sim` is None.  `transport gallery` runs
each scene once and hands its result to all exhibits of it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from transport.analysis.tracks import Tracks
from transport.results.result import Result
from transport.scene.scene import Scene
from transport.scene.tracking import Tracking
from transport.viz.convergence import convergence
from transport.viz.maps import plot_map
from transport.viz.power_flow import power_flow
from transport.viz.showroom import EYES, METERS, glossy_plate, showroom

TO_GLASS = -1.7  # rad, azimuth at which the floor's meter sees the glass ball

GLOSS = "gloss"
Draw = Callable[[Result, Tracks | None, Path, str], object]  # a result, tracks, where to, the small print


@dataclass(frozen=True)
class Exhibit:
    """One figure.  says: what it shows and its errors, in a sentence;  particles: of the run that it needs.

    tracks: how many are drawn, 0 for none;  is_solid: whether it needs a screen for 3-D pictures;  looks: of the showroom, or GLOSS.
    """

    name: str
    says: str
    draw: Draw
    sim: str | None = None
    parameters: Mapping[str, object] = field(default_factory=dict)
    particles: int = 10_000_000
    tracks: int = 0
    is_solid: bool = False
    looks: str = METERS

    @property
    def scene(self) -> Scene:
        """The scene of an exhibit that is of no experiment: the showroom with these looks, or the glossy plate."""
        return glossy_plate() if self.looks == GLOSS else showroom(self.looks)

    @property
    def ways(self) -> dict[str, object]:
        """How that is run: dim directions of the room want survivors of a roulette that weigh little."""
        return {"tracking": Tracking(roulette=1e-9)} if self.looks == METERS else {}


def draw_arrow(
    axes: Axes, start: ArrayLike, way: ArrayLike, colour: str, width: float = 4.0, **style: object
) -> None:
    """An arrow from a place along a vector, in the coordinates of the axes; style: of its zorder, alpha and the like."""
    start, way = np.asarray(start, dtype=float), np.asarray(way, dtype=float)
    shape = {
        "arrowstyle": "-|>,head_width=0.4,head_length=0.7",
        "mutation_scale": 10 + 3 * width,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    axes.annotate(
        "",
        start + way,
        start,
        arrowprops=shape | {"color": colour, "lw": width} | style,
        annotation_clip=False,
    )


def bare_panel(axes: Axes, xlim: tuple[float, float], ylim: tuple[float, float]) -> None:
    """Axes for a sketch: equal lengths both ways, without a frame, ticks and a grid."""
    axes.set(aspect="equal", xlim=xlim, ylim=ylim)
    axes.axis("off")


def _map(name: str, title: str, **how: object) -> Draw:
    return lambda result, tracks, path, note: plot_map(result[name], path, title=title, note=note, **how)


def _settling(result: Result, tracks: Tracks | None, path: Path, note: str) -> object:
    title = "More photons, a better number: the error falls as 1/√N"
    return convergence(
        result, result.ledger.absorbed_by["floor"], path, title=title, note=note, name="absorbed by the floor"
    )


def _flow(result: Result, tracks: Tracks | None, path: Path, note: str) -> object:
    return power_flow(result, path, title="Where the power of the lamp went", note=note)


def _solid(title: str, result: Result, tracks: Tracks | None, path: Path, note: str) -> object:
    from transport.viz.scene import draw_scene

    return draw_scene(result.scene, result, tracks, path, title=title, quantity="irradiance")


def _lobe(result: Result, tracks: Tracks | None, path: Path, note: str) -> object:
    from transport.viz.lobes_in_place import add_lobe
    from transport.viz.scene import draw_scene

    plotter = draw_scene(result.scene, tracks=tracks)
    add_lobe(plotter, result["plate"], "radiance_out", size=0.6)
    plotter.screenshot(path, return_img=False)
    plotter.close()
    return path


EXHIBITS = (
    Exhibit(
        "room",
        "A room in space: surfaces coloured by irradiance on a logarithmic scale, the lamp glowing, fog as a volume, and"
        " the ways of a hundred particles by weight; cells with few hits are grey, so that no colour is mere noise.",
        partial(_solid, "One of each thing"),
        tracks=100,
        is_solid=True,
    ),
    Exhibit(
        "lobe",
        "What leaves a glossy plate in a slanting beam, where it leaves: the distance from the plate, and the colour, say the"
        " radiance in that direction, highest near the mirror's and beyond; its standard errors, 3 % in the median bin, are not drawn.",
        _lobe,
        particles=4_000_000,
        tracks=60,
        is_solid=True,
        looks=GLOSS,
    ),
    Exhibit(
        "irradiance_map",
        "Light on the floor: shadows of a mirror ball and of fog, and the light that a glass ball gathers; beside it the"
        " relative standard error of every bin, and a cut through the focus with bars of two standard errors.",
        _map("floor", "Light on the floor", quantity="irradiance", decades=2, cut=True),
    ),
    Exhibit(
        "fluence_map",
        "Fluence rate in a slice through the room, by cells, with the relative standard error of each; within the mirror"
        " ball, where nothing comes, no error is known, and it is hatched.",
        _map("slice", "Fluence rate in a slice of the room", quantity="fluence_rate", decades=2, cut=True),
    ),
    Exhibit(
        "radiance_map",
        "What comes to a patch of the floor by direction, drawn from above, over three decades: the lamp,"
        " through the glass ball and past it, and"
        " the walls; dim directions have few counts, as the map of errors tells, and what nothing came from is hatched.",
        _map("sky", "Where light on the floor comes from", quantity="radiance", decades=3, cut=TO_GLASS),
    ),
    Exhibit(
        "power_flow",
        "The ledger as a flow: widths are to scale, every end has its number and standard error, and they add up to what"
        " was emitted.",
        _flow,
    ),
    Exhibit(
        "convergence",
        "A number while it settles: the mean of the batches so far with a band that covers with 95 %, and its standard"
        " error on the line of one over the root of the particles; early errors are themselves uncertain (grey).",
        _settling,
    ),
    Exhibit(
        "phase_density",
        "Position against velocity of a water bag between mirrors, which winds into filaments of one and the same density;"
        " below, relative standard errors: one in the root of the counts, and hatched where nothing was.",
        _map("waterbag", "A water bag winds into filaments", quantity="density"),
        sim="phase_space",
        parameters={"start": "waterbag"},
        particles=4_000_000,
    ),
    Exhibit(
        "camera_picture",
        "The room as a camera sees it, by histories that start at its pinhole, over three decades of radiance; the"
        " errors beside it are largest where the glass ball lights, with single bright pixels round about, and in the fog.",
        _map("view", "The room, by histories that start at the camera", decades=3),
        particles=12_000_000,
        looks=EYES,
    ),
    Exhibit(
        "environment_map",
        "Radiance from all directions at a place in the room, seen from there, with its relative standard"
        " error: polar angle from above, azimuth growing to the left; where the room is open nothing comes,"
        " and no error is known (hatched).",
        _map("around", "All directions at a place in the room", decades=3),
        particles=12_000_000,
        looks=EYES,
    ),
)
