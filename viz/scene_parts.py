"""A scene taken apart into what is drawn of it: surfaces, media, sources and detectors, with what was read painted on.

A wall of a closed room shows only the side that the room sees, and one that a detector looks at only that side, so that
the wall between the camera and what it is to see is looked through.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.flat import Plane
from transport.geometry.shape import Point, Shape
from transport.results.result import Result
from transport.scene.detectors import Detector
from transport.scene.media import Grid
from transport.scene.scene import Scene
from transport.validation import SceneError
from transport.viz.facets import Facets, facets_of, half_box
from transport.viz.painted import OF_VOLUMES, SYMBOLS, Paint, paint_of
from transport.viz.scene_frame import Frame
from transport.viz.solids import as_polydata, outline
from transport.viz.volume_cuts import cuts_of, paint_of_cells

if TYPE_CHECKING:
    import pyvista

FRONT, BACK, NOWHERE = "front", "back", "nowhere"
ALL_BUT = 0.97  # of a shape's facets that have the whole scene on one side, for it to be a wall of it
FLAT = 1e-6  # of the scene's size: as far off a plane is on it
SAMPLES = 300  # facets of a shape that are asked


@dataclass(frozen=True)
class Part:
    """One thing in a picture.

    kind: "surface", "medium", "source", "detector" or "cells" of a volume;  what: the object that it shows;  names: what to call it;
    facets: what is drawn of it;  paint: what was read of it, if anything;  side: of its shape that is looked at or emits;
    seen_from: the one side from which it is shown, None for both, NOWHERE where neither;  is_other_side: of a wall that is
    painted on one side, the bare one;  is_on_surface: of a detector or a source whose surface is drawn and painted as well;
    told: what a detector without bins of place read, in words.
    """

    kind: str
    what: object
    shape: Shape
    names: tuple[str, ...]
    facets: Facets
    frame: Frame
    paint: Paint | None = None
    side: str | None = None
    seen_from: str | None = None
    is_other_side: bool = False
    is_on_surface: bool = False
    told: str | None = None

    @property
    def name(self) -> str:
        """Its name, or the first of several and how many more there are."""
        return self.names[0] + (f" + {len(self.names) - 1}" if len(self.names) > 1 else "")

    @property
    def is_clear(self) -> bool:
        """Whether light goes through it."""
        material = getattr(self.what, "material", None)
        return material is not None and any(each.is_clear for each in material.elements)

    @property
    def is_empty(self) -> bool:
        """Whether it only bounds what is inside, and does nothing."""
        return not getattr(getattr(self.what, "material", None), "acts", True)

    @property
    def is_mirror(self) -> bool:
        material = getattr(self.what, "material", None)
        return material is not None and any(each.row().interaction == "mirror" for each in material.elements)

    @property
    def has_bins(self) -> bool:
        """Whether it is painted by place, and not in one colour."""
        return self.paint is not None and self.paint.words is None

    def drawn(self) -> pyvista.PolyData:
        """Its facets [m] with what was read of each as cell arrays."""
        found = as_polydata(self.facets)
        for name, column in (self.paint.on(self.facets.bins) if self.paint else {}).items():
            found.cell_data[name] = column
        if self.paint:
            found.field_data["unit"] = [self.paint.unit]
        return found

    def outlined(self) -> pyvista.PolyData:
        return outline(self.shape, self.frame.bounds)


def parts_of(
    scene: Scene, frame: Frame, result: Result | None = None, quantity: str | None = None
) -> list[Part]:
    """All parts of a scene that a picture of this frame shows.

    quantity: painted where a detector of the result tells it, "irradiance" or "exitance", or "fluence_rate" of volumes;
    None: irradiance, or exitance where nothing arrives anywhere, and what volumes read.
    """
    read = {}
    if result is not None and quantity not in OF_VOLUMES:
        read |= _paints(scene, result, quantity)
    if result is not None and (quantity is None or quantity in OF_VOLUMES):
        read |= _paints_of_volumes(scene, result)
    parts = [
        *_surfaces(scene, frame, read),
        *_media(scene, frame),
        *_detectors(scene, frame, read),
        *_cells(scene, frame, read),
        *_sources(scene, frame, read),
    ]
    return [replace(part, seen_from=seen_from(part, parts)) for part in parts]


def left_out(scene: Scene, frame: Frame) -> list[str]:
    """The names of surfaces that are so much larger than the frame that they are not drawn."""
    return [
        surface.name or f"surfaces[{number}]"
        for number, surface in enumerate(scene.surfaces)
        if frame.cut(surface.shape) is None
    ]


def _paints(scene: Scene, result: Result, quantity: str | None) -> dict[str, Paint]:
    """What each detector at a place read, by its name."""
    wanted = ("irradiance", "exitance") if quantity is None else (quantity,)
    found: dict[str, Paint] = {}
    for name in wanted:
        found = {}
        for meter in scene.meters:
            try:
                found[meter.name] = paint_of(result[meter.name], name, scene.duration)
            except SceneError:  # of a shape without end, or backwards, where this is not known
                continue
        if any((paint.values > 0).any() for paint in found.values()):
            break
    return found


def _paints_of_volumes(scene: Scene, result: Result) -> dict[str, Paint]:
    """What each volume detector read, by its name."""
    found = {}
    for volume in scene.volumes:
        try:
            found[volume.name] = paint_of_cells(result[volume.name])
        except SceneError:  # backwards, where this is not known
            continue
    return found


def _surfaces(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    for number, surface in enumerate(scene.surfaces):
        shape = frame.cut(surface.shape)
        if shape is None:
            continue
        name = surface.name or f"surfaces[{number}]"
        lookers = [
            meter for meter in scene.meters if scene.shape_of(meter) == surface.shape and meter.name in read
        ]
        best = _best(lookers)
        plain = Part("surface", surface, shape, (name,), facets_of(shape, None, frame.bounds), frame)
        if not best or shape is not surface.shape:
            yield plain
            continue
        for side, meter in best.items():
            facets = facets_of(shape, meter.positions)
            yield replace(plain, facets=facets, paint=read[meter.name], side=side)
        if len(best) == 1 and not plain.is_clear:
            (side,) = best
            yield replace(plain, side=FRONT if side == BACK else BACK, is_other_side=True)


def _best(meters: list[Detector]) -> dict[str, Detector]:
    """Of each side the meter that tells most: by place, then of all that comes, then the first."""

    def rank(meter: Detector) -> tuple[bool, bool]:
        return meter.positions is None, meter.via is not None or meter.events is not None

    found: dict[str, Detector] = {}
    for meter in sorted(meters, key=rank):
        found.setdefault(_side_of(meter), meter)
    return found


def _media(scene: Scene, frame: Frame) -> Iterator[Part]:
    """What fills closed shapes and scatters, absorbs or glows."""
    for number, surface in enumerate(scene.surfaces):
        medium, shape = surface.inside, frame.cut(surface.shape)
        name = (f"inside {surface.name or f'surfaces[{number}]'}",)
        if shape is None or not _is_seen(medium):
            continue
        if shape.is_closed:
            yield Part("medium", medium, shape, name, facets_of(shape, None, frame.bounds), frame)
        elif isinstance(shape, Plane):
            yield Part("medium", medium, shape, name, half_box(shape, frame.bounds), frame)


def _is_seen(medium: object) -> bool:
    """Whether it does anything to light but bend it."""
    return isinstance(medium, Grid) or (medium is not None and (medium.extinction > 0 or medium.emission > 0))


def _detectors(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    """One part for all detectors of one place; those on surfaces are outlines only."""
    placed: dict[object, list[object]] = {}
    for detector in scene.detectors:
        if hasattr(detector, "position"):
            placed.setdefault(Point(position=detector.position), []).append(detector)
        elif hasattr(detector, "shape"):
            placed.setdefault(scene.shape_of(detector), []).append(detector)
    solid = [surface.shape for surface in scene.surfaces]
    for shape, several in placed.items():
        cut = frame.cut(shape)
        if cut is None:
            continue
        names = tuple(detector.name for detector in several)
        facets = facets_of(cut, None, frame.bounds)
        plain = Part(
            "detector",
            several[0],
            cut,
            names,
            facets,
            frame,
            side=_side_of(several[0]),
            is_on_surface=shape in solid,
            told=_in_words(several, read),
        )
        best = _best([each for each in several if isinstance(each, Detector) and each.name in read])
        if shape in solid or not best or cut is not shape:
            yield plain
            continue
        for side, meter in best.items():
            yield replace(
                plain,
                facets=facets_of(shape, meter.positions),
                paint=read[meter.name],
                side=side,
                seen_from=side if len(best) == 2 or shape.is_closed else None,
            )


def _cells(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    """Cuts through volume detectors with cells."""
    for volume in scene.volumes:
        paint, shape = read.get(volume.name), scene.shape_of(volume)
        if paint is not None and paint.words is None and frame.cut(shape) is shape:
            facets = cuts_of(volume, shape, paint)
            yield Part("cells", volume, shape, (volume.name,), facets, frame, paint=paint)


def _side_of(detector: object) -> str | None:
    if not isinstance(detector, Detector):
        return None
    return BACK if detector.is_back else FRONT


def _in_words(several: list[object], read: dict[str, Paint]) -> str | None:
    """What one detector alone at its place read, where that is one number."""
    if len(several) > 1 or several[0].name not in read:
        return None
    paint = read[several[0].name]
    return None if paint.words is None else f"{(SYMBOLS | OF_VOLUMES)[paint.quantity]} = {paint.words}"


def _sources(scene: Scene, frame: Frame, read: dict[str, Paint]) -> Iterator[Part]:
    painted = {scene.shape_of(meter) for meter in scene.meters if meter.name in read}
    solid = {surface.shape for surface in scene.surfaces}
    for number, source in enumerate(scene.sources):
        if number in frame.distant:
            continue
        whole = scene.shape_of(source)
        shape = frame.cut(whole)
        if shape is None:
            continue
        name = source.shape if isinstance(source.shape, str) else f"source {number}"
        side = BACK if source.is_back else FRONT
        facets = facets_of(shape, None, frame.bounds)
        covered = whole in painted and whole in solid
        yield Part("source", source, shape, (str(name),), facets, frame, side=side, is_on_surface=covered)


def is_hazed(part: Part, parts: list[Part]) -> bool:
    """Whether a medium is drawn as a haze: not where colours of what was read lie on its bounds, nor voxels over cuts."""
    if part.kind != "medium":
        return False
    painted = [each for each in parts if each.paint is not None]
    if isinstance(part.what, Grid) and any(each.kind == "cells" for each in painted):
        return False
    return not any(each.shape == part.shape for each in painted)


def block_names(parts: list[Part]) -> list[str]:
    """A name for each part, each once."""
    names, taken = [], set()
    for part in parts:
        title = f"{part.kind} {part.name}" + (f" {part.side}" if part.paint and part.side else "")
        again = (f"{title} {k}" for k in itertools.count(2))
        name = title if title not in taken else next(each for each in again if each not in taken)
        taken.add(name)
        names.append(name)
    return names


# ---- The side of a part that is shown.


def seen_from(part: Part, parts: list[Part]) -> str | None:
    """The side from which a wall is shown: the painted one, else the one that all the rest of the scene is on."""
    if part.kind == "surface" and part.side is not None and not part.is_clear:
        if not part.is_other_side:
            return part.side
        inner = _inner_side(part, parts)
        return NOWHERE if inner not in (None, part.side) else part.side
    if part.kind == "surface" and not part.is_clear:
        return _inner_side(part, parts)
    return part.seen_from


def _inner_side(part: Part, parts: list[Part]) -> str | None:
    """The side of a shape on which all the others are, if there is one."""
    finite = [each for each in parts if len(each.facets.points) and not each.shape.is_infinite]
    others = [each for each in finite if each.shape != part.shape]
    if len(part.facets.faces) == 0:
        return None
    if not others:
        return _own_side(part, parts)
    points = np.concatenate([_some(each.facets.points, 40) for each in others])
    areas = part.facets.vector_areas
    chosen = _some(np.arange(len(areas)), SAMPLES)
    heights = np.einsum("pk,ck->cp", points, areas[chosen])
    heights -= np.einsum("ck,ck->c", part.facets.centres[chosen], areas[chosen])[:, None]
    heights /= np.maximum(np.linalg.norm(areas[chosen], axis=1), 1e-300)[:, None]
    flat = FLAT * part.frame.size + _sagitta(part)
    is_behind, is_before = (heights <= flat).all(axis=1).mean(), (heights >= -flat).all(axis=1).mean()
    if (np.abs(heights) <= flat).all():
        return None
    if is_behind >= ALL_BUT:
        return BACK
    return FRONT if is_before >= ALL_BUT else None


def _own_side(part: Part, parts: list[Part]) -> str | None:
    """The one side of a shape alone in its scene that something emits from, or looks at."""
    sides = set()
    for each in parts:
        if each.kind == "source" and each.shape == part.shape:
            sides.add(each.side if each.what.emission.has_side else BACK)
        elif each.kind == "detector" and each.side:
            sides.add(each.side)
    return sides.pop() if len(sides) == 1 else None


def _sagitta(part: Part) -> float:
    """How far flat facets lie within what is round [m]."""
    shape = part.shape
    return 0.002 * shape.extent if len(part.facets.faces) > 12 and np.isfinite(shape.extent) else 0.0


def _some(array: np.ndarray, most: int) -> np.ndarray:
    return array[:: max(1, -(-len(array) // most))]
