"""Parts of a scene before any check: sources, surfaces, detectors, the surrounding medium, the clock."""

from collections.abc import Iterable
from dataclasses import fields
from functools import cached_property

from transport.geometry.shape import Shape
from transport.scene.cameras import Camera, EnvironmentMap, Instrument, LightField
from transport.scene.detectors import Detector
from transport.scene.materials import AnyMedium, Surface
from transport.scene.media import Medium, Vacuum
from transport.scene.phase_space import PhaseSpace, Snapshot
from transport.scene.points import PointDetector
from transport.scene.sides import AnyDetector
from transport.scene.sources import Source
from transport.scene.volumes import VolumeDetector
from transport.validation import (
    Converted,
    PartsField,
    join_names,
    name_hint,
    refuse,
    scene_object,
    short_repr,
)

DETECTOR_TYPES = (
    Camera,
    Detector,
    EnvironmentMap,
    LightField,
    PhaseSpace,
    PointDetector,
    Snapshot,
    VolumeDetector,
)
AnyDetectorType = (
    Camera | Detector | EnvironmentMap | LightField | PhaseSpace | PointDetector | Snapshot | VolumeDetector
)


@scene_object
class SceneParts:
    """The parts of a scene and look-ups among them; `Scene` is these parts after its checks."""

    sources: PartsField[Source]
    surfaces: PartsField[Surface] = ()
    detectors: Converted[Iterable[AnyDetector] | AnyDetector, tuple[AnyDetectorType, ...]] = ()
    medium: Medium | Vacuum | None = None
    duration: float | None = None

    @property
    def measured_in(self) -> str:
        """Unit of the emission of all sources, "watts" or "particles"; media that emit do so in watts.

        Returns
        -------
        str
        """
        return self.sources[0].emission.measured_in if self.sources else "watts"

    @cached_property
    def proofs(self) -> dict:
        """Cache of what geometry proves about the scene, shared by all its runs and saved in no file.

        Returns
        -------
        dict
        """
        return {}

    @cached_property
    def _named(self) -> dict[str, Surface]:
        """Surfaces by name."""
        return {surface.name: surface for surface in self.surfaces if surface.name is not None}

    def __getstate__(self) -> dict[str, object]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def meters(self) -> tuple[Detector, ...]:
        """The detectors on shapes and surfaces, those of class Detector.

        Returns
        -------
        tuple of Detector
        """
        return tuple(part for part in self.detectors if isinstance(part, Detector))

    @cached_property
    def phase_spaces(self) -> tuple[PhaseSpace, ...]:
        """The detectors of class PhaseSpace.

        Returns
        -------
        tuple of PhaseSpace
        """
        return tuple(part for part in self.detectors if isinstance(part, PhaseSpace))

    @cached_property
    def snapshots(self) -> tuple[Snapshot, ...]:
        """The detectors of class Snapshot.

        Returns
        -------
        tuple of Snapshot
        """
        return tuple(part for part in self.detectors if isinstance(part, Snapshot))

    @cached_property
    def volumes(self) -> tuple[VolumeDetector, ...]:
        """The detectors of class VolumeDetector.

        Returns
        -------
        tuple of VolumeDetector
        """
        return tuple(part for part in self.detectors if isinstance(part, VolumeDetector))

    @cached_property
    def points(self) -> tuple[PointDetector, ...]:
        """The detectors of class PointDetector.

        Returns
        -------
        tuple of PointDetector
        """
        return tuple(part for part in self.detectors if isinstance(part, PointDetector))

    @cached_property
    def instruments(self) -> tuple[Instrument, ...]:
        """The detectors that only backward histories reach, such as a Camera.

        Returns
        -------
        tuple
        """
        return tuple(part for part in self.detectors if isinstance(part, Instrument))

    @cached_property
    def path_media(self) -> tuple[AnyMedium, ...]:
        """Return the media in which any detector keeps path lengths, each once."""
        return tuple(dict.fromkeys(medium for one in self.meters for medium in one.path_lengths or ()))

    @cached_property
    def visited(self) -> tuple[str, ...]:
        """The names of detectors and surfaces that occur in a `via`, each once.

        Returns
        -------
        tuple of str
        """
        return tuple(dict.fromkeys(name for detector in self.meters for name in detector.via or ()))

    def surface(self, name: str) -> Surface:
        """Return the surface of that name.

        Parameters
        ----------
        name : str

        Returns
        -------
        Surface

        Raises
        ------
        SceneError
            If no surface has this name.
        """
        return self._surface_for(self, "name", name)

    def shape_of(self, user: Source | Detector) -> Shape:
        """Return the shape of a source or detector: its own, or that of the surface that it names.

        Parameters
        ----------
        user : Source, Detector or VolumeDetector

        Returns
        -------
        Shape

        Raises
        ------
        SceneError
            If it names a surface that is not in the scene.
        """
        return (
            user.shape
            if isinstance(user.shape, Shape)
            else self._surface_for(user, "shape", user.shape).shape
        )

    def _surface_for(self, user: object, parameter: str, name: str) -> Surface:
        if name not in self._named:
            hint = name_hint(name, self._named)
            refuse(user, f"{parameter} must name a surface, got {short_repr(name)}; {hint}")
        return self._named[name]


def surface_name(scene: SceneParts, which: Surface | int) -> str:
    """Return how a message names a surface, given itself or its number in the scene."""
    number = scene.surfaces.index(which) if isinstance(which, Surface) else which
    name = scene.surfaces[number].name
    return f"Surface {name!r}" if name else f"surfaces[{number}]"


def join_surface_names(scene: SceneParts, numbers: Iterable[int], most: int = 6) -> str:
    """Return names of surfaces, given their numbers, as "a, b and c"; beyond `most` the number of others."""
    return join_names([surface_name(scene, number) for number in numbers], most)


def named_media(scene: SceneParts) -> list[AnyMedium]:
    """Return the media that a scene and its surfaces name."""
    named = scene.medium, *(medium for surface in scene.surfaces for medium in (surface.front, surface.back))
    return [medium for medium in named if medium is not None]


def has_emission(scene: SceneParts) -> bool:
    """Return whether a medium in the scene emits."""
    return any(medium.emission > 0 for medium in named_media(scene))
