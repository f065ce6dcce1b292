"""A scene: sources, surfaces and detectors that fit together, checked once and never changed."""

from collections import Counter
from collections.abc import Iterable
from functools import cached_property
from os import PathLike

from transport.bodies.filling import glows, names_media
from transport.bodies.listing import AnyMedium, medium_at
from transport.cameras import Camera, EnvironmentMap, Instrument
from transport.detectors import Detector
from transport.fields import Converted, Parts
from transport.materials import Dielectric, Surface, ThinLens, simple_parts
from transport.materials.surface import settled_medium
from transport.media import Grid, Medium, Vacuum
from transport.phase_space import PhaseSpace, Snapshot
from transport.points import PointDetector, check_points
from transport.shapes import Shape
from transport.sides import AnyDetector
from transport.soundness import check_scene
from transport.sources import Source
from transport.validation import (
    as_floats,
    refuse,
    scene_object,
    settle_positive,
    shown,
    store,
    suggestion,
)
from transport.volumes import VolumeDetector

LOOKING = (Camera, Detector, EnvironmentMap, PhaseSpace, PointDetector, Snapshot, VolumeDetector)
Looking = Camera | Detector | EnvironmentMap | PhaseSpace | PointDetector | Snapshot | VolumeDetector


@scene_object
class Scene:
    """A scene: sources, surfaces, detectors and media; immutable, checked when it is made.

    Parameters
    ----------
    sources : Source or iterable of Source
        What emits. May be empty if a medium emits. All sources emit watts (Lambertian, Isotropic, Beam),
        or all emit particles (Gas, Effusive).
    surfaces : Surface or iterable of Surface, default ()
        Shapes with materials, and media on their sides.
    detectors : detector or iterable of detectors, default ()
        Detector, VolumeDetector, PointDetector, Camera, EnvironmentMap, PhaseSpace and Snapshot.
    medium : Medium or Vacuum, default None
        Fills all space that is not inside a body with its own medium. None: vacuum.
    duration : float, default None
        With a duration [s] the scene has a clock that runs from 0 to the duration; without one it is
        steady.

    Raises
    ------
    SceneError
        If names are unknown or not unique, or if parts contradict each other.

    Examples
    --------
    A point source over a black disk:

    >>> import transport as tp
    >>> scene = tp.Scene(
    ...     sources=[tp.Source(tp.Point(position=(0, 0, 1)), tp.Isotropic(power=1.0))],
    ...     surfaces=[tp.Surface(tp.Disk(radius=1.0), tp.Black(), name="disk")],
    ...     detectors=[tp.Detector("disk")],
    ... )
    >>> scene.measured_in
    'watts'
    >>> [detector.name for detector in scene.meters]
    ['disk']
    >>> tp.Scene.from_json(scene.to_json()) == scene
    True
    """

    sources: Parts[Source]
    surfaces: Parts[Surface] = ()
    detectors: Converted[Iterable[AnyDetector] | AnyDetector, tuple[Looking, ...]] = ()
    medium: Medium | Vacuum | None = None
    duration: float | None = None

    def __post_init__(self) -> None:
        _settle_parts(self, "sources", Source)
        _settle_parts(self, "surfaces", Surface)
        _settle_parts(self, "detectors", *LOOKING)
        if self.duration is not None:
            settle_positive(self, "duration")
        self._check_medium()
        self._check_has_source()
        self._check_names()
        self._check_via()
        self._check_emissions()
        for user in (*self.sources, *self.meters, *self.volumes):
            user.check_shape(self.shape_of(user))
        for user in (*self.sources, *self.detectors):
            user.check_clock(self.duration)
        check_points(self)
        check_scene(self)

    def to_json(self, path: str | PathLike | None = None) -> str:
        """Return the scene as JSON text, from which `from_json` restores it bit by bit.

        Parameters
        ----------
        path : str or PathLike, default None
            File to write the text to as well.

        Returns
        -------
        str

        Raises
        ------
        SceneError
            If a part cannot be written, such as the function of an InverseCDF. See
            transport/guides/scenes.md.
        """
        from transport.written.documents import scene_text

        return scene_text(self, path)

    @staticmethod
    def from_json(source: str | PathLike) -> "Scene":
        """Return the scene described by JSON, written by `to_json` or by hand.

        Parameters
        ----------
        source : str or PathLike
            A file's path, or the text itself.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            If the text is invalid; the message names the place, as in "surfaces[2].material.albedo".
        """
        from transport.written.documents import scene_of

        return scene_of(source)

    @property
    def measured_in(self) -> str:
        """What all sources emit: "watts" or "particles"; media that emit do so in watts.

        Returns
        -------
        str
        """
        return self.sources[0].emission.measured_in if self.sources else "watts"

    def _repr_html_(self) -> str:
        from transport.html.scenes import scene_html

        return scene_html(self)

    @cached_property
    def proofs(self) -> dict:
        """Cache of what geometry proves about the scene, shared by all its runs and saved in no file.

        Returns
        -------
        dict
        """
        return {}

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in vars(self).items() if name != "proofs"}

    @property
    def meters(self) -> tuple[Detector, ...]:
        """The detectors on shapes and surfaces: those of class Detector.

        Returns
        -------
        tuple of Detector
        """
        return tuple(part for part in self.detectors if isinstance(part, Detector))

    @property
    def phase_spaces(self) -> tuple[PhaseSpace, ...]:
        """The detectors of class PhaseSpace.

        Returns
        -------
        tuple of PhaseSpace
        """
        return tuple(part for part in self.detectors if isinstance(part, PhaseSpace))

    @property
    def snapshots(self) -> tuple[Snapshot, ...]:
        """The detectors of class Snapshot.

        Returns
        -------
        tuple of Snapshot
        """
        return tuple(part for part in self.detectors if isinstance(part, Snapshot))

    @property
    def volumes(self) -> tuple[VolumeDetector, ...]:
        """The detectors of class VolumeDetector.

        Returns
        -------
        tuple of VolumeDetector
        """
        return tuple(part for part in self.detectors if isinstance(part, VolumeDetector))

    @property
    def points(self) -> tuple[PointDetector, ...]:
        """The detectors of class PointDetector.

        Returns
        -------
        tuple of PointDetector
        """
        return tuple(part for part in self.detectors if isinstance(part, PointDetector))

    @property
    def instruments(self) -> tuple[Instrument, ...]:
        """The detectors that only backward histories reach: each Camera and EnvironmentMap.

        Returns
        -------
        tuple
        """
        return tuple(part for part in self.detectors if isinstance(part, Instrument))

    @property
    def visited(self) -> tuple[str, ...]:
        """The names of detectors and surfaces that occur in a `via`, each once.

        Returns
        -------
        tuple of str
        """
        return tuple(dict.fromkeys(name for meter in self.meters for name in meter.via or ()))

    def medium_at(self, position: Iterable[float]) -> AnyMedium:
        """Return the medium at a point: that of the innermost body around it, else the surrounding one.

        Parameters
        ----------
        position : vector
            Point [m].

        Returns
        -------
        Medium, Grid or Vacuum

        Raises
        ------
        SceneError
            If the position is not three finite numbers.

        Examples
        --------
        >>> import transport as tp
        >>> ball = tp.Surface(tp.Sphere(radius=1.0), tp.Transparent(), inside=tp.Medium(absorption=0.5))
        >>> scene = tp.Scene(tp.Source(tp.Point(), tp.Isotropic(power=1.0)), ball)
        >>> scene.medium_at((0, 0, 0.5)), scene.medium_at((0, 0, 2))
        (Medium(absorption=0.5), Vacuum())
        """
        place = as_floats(position)
        if place is None or len(place) != 3:
            refuse(self, f"position must be three finite numbers, got {shown(position)}")
        return medium_at(self, place)

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
        named = {surface.name: surface for surface in self.surfaces if surface.name is not None}
        if name not in named:
            refuse(user, f"{parameter} must name a surface, got {shown(name)}; {suggestion(name, named)}")
        return named[name]

    def _check_medium(self) -> None:
        """The surrounding medium is one that fills all space."""
        if self.medium is None:
            return
        settled_medium(self, "medium", self.medium)
        if isinstance(self.medium, Grid):
            cure = "write Surface(grid.box, Transparent(), inside=grid)"
            refuse(self, f"medium must fill all space, got {shown(self.medium)}, which ends; {cure}")

    def _check_has_source(self) -> None:
        """Something emits: a source, or the medium of a body."""
        if not self.sources and not glows(self):
            cure = "write sources=[Source(...)], or let a medium emit"
            refuse(self, f"sources must hold at least one Source, got none; {cure}")

    def _check_names(self) -> None:
        for parts in (self.surfaces, self.detectors):
            counts = Counter(part.name for part in parts if part.name is not None)
            for name, count in counts.items():
                if count > 1:
                    kinds = Counter(type(part).__name__ for part in parts if part.name == name)
                    got = " and ".join(f"{n} {kind}{'s' if n > 1 else ''}" for kind, n in kinds.items())
                    refuse(self, f"name must be unique, got {got} {name!r}; give each its own name=")
        names = {surface.name for surface in self.surfaces}
        for part in self.detectors:
            if part.name in names and not self._meters_its_namesake(part):
                refuse(
                    part,
                    f"name must not be that of a surface it does not meter, got {part.name!r}; rename it",
                )

    def _meters_its_namesake(self, part: Looking) -> bool:
        return (
            isinstance(part, Detector | VolumeDetector)
            and self.shape_of(part) == self.surface(part.name).shape
        )

    def _check_via(self) -> None:
        names = [part.name for part in (*self.meters, *self.surfaces) if part.name is not None]
        for meter in self.meters:
            for name in meter.via or ():
                if name not in names:
                    cure = suggestion(name, dict.fromkeys(names))
                    refuse(meter, f"via must name a detector or a surface, got {name!r}; {cure}")

    def _check_emissions(self) -> None:
        if len({source.emission.measured_in for source in self.sources}) > 1:
            kinds = ", ".join(sorted({type(source.emission).__name__ for source in self.sources}))
            refuse(self, f"sources must be all in watts or all in particles, got {kinds}; use two scenes")
        for surface in self.surfaces:
            for part in simple_parts(surface.material):
                if getattr(part, "speed", None) is not None:
                    self._check_wall(surface, part.speed)
                if isinstance(part, (Dielectric, ThinLens)):
                    self._check_optics(surface, part)

    def _check_wall(self, surface: Surface, speed: object) -> None:
        """Refuse a thermal wall for energies, or for particles of another mass than its own."""
        if self.measured_in == "watts":
            cure = "leave speed out of Diffuse, or emit particles with Gas or Effusive"
            refuse(surface, f"speeds of its own a wall gives to particles, not to watts; {cure}")
        masses = {source.emission.mass for source in self.sources} - {None}
        mass = getattr(speed, "mass", None)
        if mass is not None and masses - {mass}:
            got = ", ".join(f"{other} kg" for other in sorted(masses - {mass}))
            cure = "a wall gives the speeds of one mass; take that mass, and a scene for each species"
            refuse(surface, f"its Maxwellian is of particles of {mass} kg, got {got} from a source; {cure}")

    def _check_optics(self, surface: Surface, part: Dielectric | ThinLens) -> None:
        """Refuse a boundary of media or a lens for particles, and glass of unknown media with a clock."""
        kind = type(part).__name__
        if self.measured_in == "particles":
            cure = "emit watts, or leave it out"
            refuse(surface, f"material must not be a {kind} in a scene of particles, got {part}; {cure}")
        if isinstance(part, Dielectric) and self.duration is not None and not names_media(self):
            must = f"material must not be a Dielectric in a scene with a duration, got {self.duration} s"
            cure = f"name its medium, inside=Medium(index={part.index_inside:g}), which says how fast light is there"
            refuse(surface, f"{must} and no media; {cure}, or leave out duration")


def _settle_parts(scene: Scene, name: str, *kinds: type) -> None:
    """The field is a tuple of parts of these kinds; a single part, or any iterable of them, is accepted."""
    value = getattr(scene, name)
    must = f"{name} must be a list of {' or '.join(kind.__name__ for kind in kinds)} objects"
    if isinstance(value, kinds):
        value = (value,)
    if isinstance(value, (str, bytes, dict)) or not isinstance(value, Iterable):
        refuse(scene, f"{must}, got {shown(value)}")
    parts = tuple(value)
    for place, part in enumerate(parts):
        if not isinstance(part, kinds):
            refuse(scene, f"{must}, got {shown(part)} as {name}[{place}]; put it into its own list")
    store(scene, **{name: parts})
