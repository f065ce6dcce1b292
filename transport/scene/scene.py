"""A scene: sources, surfaces and detectors that fit together, checked once and never changed."""

from collections import Counter
from collections.abc import Iterable
from os import PathLike
from typing import TYPE_CHECKING

from transport.renderers import function_for
from transport.scene.bodies import medium_at
from transport.scene.checks.check_scene import check_scene
from transport.scene.detectors import Detector
from transport.scene.indices import lacks_indices, with_indices
from transport.scene.materials import AnyMedium, Material, Surface, coerce_medium
from transport.scene.media import Grid, Medium, Vacuum
from transport.scene.parts import DETECTOR_TYPES, AnyDetectorType, SceneParts, has_emission, named_media
from transport.scene.sides import AnyDetector
from transport.scene.sources import Source
from transport.scene.volumes import VolumeDetector
from transport.validation import (
    Converted,
    PartsField,
    as_floats,
    coerce_positive,
    name_hint,
    optional_packages,
    refuse,
    scene_object,
    set_fields,
    short_repr,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@scene_object
class Scene(SceneParts):
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

    # The fields of SceneParts again: type checkers lose what a field accepts where it is inherited.
    sources: PartsField[Source]
    surfaces: PartsField[Surface] = ()
    detectors: Converted[Iterable[AnyDetector] | AnyDetector, tuple[AnyDetectorType, ...]] = ()
    medium: Medium | Vacuum | None = None
    duration: float | None = None

    def __post_init__(self) -> None:
        _coerce_parts(self, "sources", Source)
        _coerce_parts(self, "surfaces", Surface)
        _coerce_parts(self, "detectors", *DETECTOR_TYPES)
        if self.duration is not None:
            coerce_positive(self, "duration")
        self._check_medium()
        self._check_has_source()
        self._check_names()
        self._check_via()
        self._check_emissions()
        for user in (*self.sources, *self.meters, *self.volumes):
            user.check_shape(self.shape_of(user))
        for user in (*self.sources, *self.detectors):
            user.check_clock(self.duration)
        if any(map(lacks_indices, self.surfaces)):
            parts = SceneParts(self.sources, self.surfaces, self.detectors, self.medium, self.duration)
            set_fields(self, surfaces=with_indices(parts))
            self.__dict__.pop("_named", None)  # of the surfaces before
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
        return function_for(type(self), "to_json")(self, path)

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
        return function_for(Scene, "from_json")(source)

    def plot(
        self,
        plane: str = "xz",
        at: float | None = None,
        ax: "Axes | None" = None,
        *,
        path: str | PathLike | None = None,
    ) -> "Axes":
        """Draw a plane section: surfaces by material, media, sources and detectors (needs matplotlib).

        Parameters
        ----------
        plane : {"xy", "xz", "yz"}, default "xz"
            Axes of the picture, to the right and upwards.
        at : float, optional
            Place of the plane on the third axis [m] [default: 0 if that lies within the scene, else its
            middle].
        ax : matplotlib.axes.Axes, optional
            Where to draw [default: a new figure of pyplot].
        path : path, optional
            File to write the picture to, such as "scene.png" [default: none].

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        SceneError
            If there is no such plane, or without matplotlib.

        Notes
        -----
        Arrows show the side that a flat source emits from and a flat detector counts at. A surface that lies
        within the plane is drawn as an area, sources and detectors there are hatched. What the plane does not
        meet is named beside the picture, as is what it meets outside the picture or at a point.

        Examples
        --------
        >>> import transport as tp
        >>> room = tp.Surface(tp.Box(size=2.0), tp.Diffuse(0.5), "room")
        >>> lamp = tp.Source(tp.Sphere(radius=0.1), tp.Lambertian(power=1.0))
        >>> tp.Scene(lamp, room).plot("xy").get_xlabel()
        'x  [m]'
        """
        with optional_packages("plot"):
            return function_for(type(self), "plot")(self, plane, at, ax, path=path)

    def view(self, path: str | PathLike | None = None) -> object:
        """Show the scene in 3-D: in a window, or as a picture or page (needs PyVista).

        Parameters
        ----------
        path : path, optional
            A .png of the scene, or an .html that turns under the mouse and works offline [default: a window;
            in a notebook a picture].

        Returns
        -------
        pyvista.Plotter or pathlib.Path
            The window, or the file that was written.

        Raises
        ------
        SceneError
            For another kind of file, and where this machine cannot draw; the message says what to install.
        """
        with optional_packages("view"):
            return function_for(type(self), "view")(self, path)

    def _repr_html_(self) -> str:
        return function_for(type(self), "html")(self)

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
            refuse(self, f"position must be three finite numbers, got {short_repr(position)}")
        return medium_at(self, place)

    def _check_medium(self) -> None:
        """The surrounding medium is one that fills all space."""
        if self.medium is None:
            return
        coerce_medium(self, "medium", self.medium)
        if isinstance(self.medium, Grid):
            cure = "write Surface(grid.box, Transparent(), inside=grid)"
            refuse(self, f"medium must fill all space, got {short_repr(self.medium)}, which ends; {cure}")

    def _check_has_source(self) -> None:
        """Something emits: a source, or the medium of a body."""
        if not self.sources and not has_emission(self):
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
        named: dict[str, object] = {}
        for medium in (
            self.medium,
            *(side for wall in self.surfaces for side in (wall.inside, wall.outside)),
        ):
            name = getattr(medium, "name", None)
            if name is not None and named.setdefault(name, medium) != medium:
                cure = "give each its own name="
                refuse(self, f"media that differ must not have one name, got {name!r} twice; {cure}")
        names = {surface.name for surface in self.surfaces}
        for part in self.detectors:
            if part.name in names and not self._detects_surface_of_same_name(part):
                refuse(
                    part,
                    f"name must not be that of a surface that it does not measure, got {part.name!r};"
                    " rename it",
                )

    def _detects_surface_of_same_name(self, part: AnyDetectorType) -> bool:
        return (
            isinstance(part, Detector | VolumeDetector)
            and self.shape_of(part) == self.surface(part.name).shape
        )

    def _check_via(self) -> None:
        names = [part.name for part in (*self.meters, *self.surfaces) if part.name is not None]
        for detector in self.meters:
            for name in detector.via or ():
                if name not in names:
                    cure = name_hint(name, dict.fromkeys(names))
                    refuse(detector, f"via must name a detector or a surface, got {name!r}; {cure}")

    def _check_emissions(self) -> None:
        if len({source.emission.measured_in for source in self.sources}) > 1:
            kinds = ", ".join(sorted({type(source.emission).__name__ for source in self.sources}))
            refuse(self, f"sources must be all in watts or all in particles, got {kinds}; use two scenes")
        for surface in self.surfaces:
            for part in surface.material.elements:
                if part.speed is not None:
                    self._check_wall(surface, part.speed)
                if part.is_for_light:
                    self._check_optics(surface, part)

    def _check_wall(self, surface: Surface, speed: object) -> None:
        """Refuse a thermal wall for energies, or for particles of another mass than its own."""
        if self.measured_in == "watts":
            cure = "leave speed out of Diffuse, or emit particles with Gas or Effusive"
            refuse(surface, f"a wall with a speed needs a scene of particles, got watts; {cure}")
        masses = {source.emission.mass for source in self.sources} - {None}
        mass = getattr(speed, "mass", None)
        if mass is not None and masses - {mass}:
            got = ", ".join(f"{other} kg" for other in sorted(masses - {mass}))
            cure = "a wall gives the speeds of one mass; take that mass, and a scene for each species"
            refuse(surface, f"its Maxwellian is of particles of {mass} kg, got {got} from a source; {cure}")

    def _check_optics(self, surface: Surface, part: Material) -> None:
        """Refuse a boundary of media or a lens for particles, and glass of unknown media with a clock."""
        kind = type(part).__name__
        if self.measured_in == "particles":
            cure = "emit watts, or leave it out"
            refuse(surface, f"material must not be a {kind} in a scene of particles, got {part}; {cure}")
        if part.bounds_media and self.duration is not None and not named_media(self):
            must = f"material must not be a Dielectric in a scene with a duration, got {self.duration} s"
            cure = (
                f"name its medium, inside=Medium(index={part.index_inside:g}), which says how fast light is"
                " there"
            )
            refuse(surface, f"{must} and no media; {cure}, or leave out duration")


_ORDER = ("sources", "surfaces", "detectors")
_LISTS: dict[type, str] = {Source: "sources", Surface: "surfaces"} | dict.fromkeys(
    DETECTOR_TYPES, "detectors"
)


def _coerce_parts(scene: Scene, name: str, *kinds: type) -> None:
    """The field is a tuple of parts of these kinds; a single part, or any iterable of them, is accepted."""
    value = getattr(scene, name)
    of = "detector" if len(kinds) > 1 else kinds[0].__name__
    must = f"{name} must be a list of {of} objects"
    if isinstance(value, tuple(_LISTS)):
        value = (value,)
    if isinstance(value, (str, bytes, dict)) or not isinstance(value, Iterable):
        refuse(scene, f"{must}, got {short_repr(value)}")
    parts = tuple(value)
    for place, part in enumerate(parts):
        if not isinstance(part, kinds):
            own = _LISTS.get(type(part))
            cure = (
                f"it belongs into {own}=[...]: the order is {', '.join(_ORDER)}"
                if own
                else f"write {kinds[0].__name__}(...)"
            )
            label = getattr(part, "name", None) if own else None
            got = f"{type(part).__name__} {label!r}" if label else short_repr(part)
            refuse(scene, f"{must}, got {got} as {name}[{place}]; {cure}")
    set_fields(scene, **{name: parts})
