"""A scene: sources, surfaces and detectors that fit together, checked once and never changed."""

from collections import Counter
from collections.abc import Iterable

from transport.detectors import Detector
from transport.materials import Surface
from transport.shapes import Shape
from transport.soundness import check_scene
from transport.sources import Gas, Source
from transport.validation import refuse, scene_object, settle_positive, shown, store, suggestion


@scene_object
class Scene:
    """What is simulated: at least one source, and the surfaces and detectors, each a list or a single object.

    With a `duration` [s] the clock runs from 0, when all sources start; without one the scene is steady.
    Raises SceneError for names that are unknown or not unique and for parts that do not go together.
    """

    sources: tuple[Source, ...]
    surfaces: tuple[Surface, ...] = ()
    detectors: tuple[Detector, ...] = ()
    duration: float | None = None

    def __post_init__(self) -> None:
        for name, kind in {"sources": Source, "surfaces": Surface, "detectors": Detector}.items():
            _settle_parts(self, name, kind)
        if self.duration is not None:
            settle_positive(self, "duration")
        self._check_names()
        self._check_emissions()
        for user in (*self.sources, *self.detectors):
            user.check_shape(self.shape_of(user))
        check_scene(self)

    @property
    def measured_in(self) -> str:
        """What all sources emit: "watts" or "particles"."""
        return self.sources[0].emission.measured_in

    def surface(self, name: str) -> Surface:
        """The surface of that name."""
        return self._surface_for(self, "name", name)

    def shape_of(self, user: Source | Detector) -> Shape:
        """The shape of a source or detector, looked up where it was given as a surface's name."""
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

    def _check_names(self) -> None:
        for kind, parts in {"Surface": self.surfaces, "Detector": self.detectors}.items():
            counts = Counter(part.name for part in parts if part.name is not None)
            for name, count in counts.items():
                if count > 1:
                    refuse(
                        self, f"name must be unique, got {count} {kind}s {name!r}; give each its own name="
                    )
        names = {surface.name for surface in self.surfaces}
        for meter in self.detectors:
            if meter.name in names and self.shape_of(meter) != self.surface(meter.name).shape:
                refuse(
                    meter,
                    f"name must not be that of a surface it does not meter, got {meter.name!r}; rename it",
                )

    def _check_emissions(self) -> None:
        if len({source.emission.measured_in for source in self.sources}) > 1:
            kinds = ", ".join(sorted({type(source.emission).__name__ for source in self.sources}))
            refuse(self, f"sources must be all in watts or all in particles, got {kinds}; use two scenes")
        if self.duration is None and any(isinstance(source.emission, Gas) for source in self.sources):
            refuse(self, "duration must be given with a Gas, got None; write duration=... in seconds")


def _settle_parts(scene: Scene, name: str, kind: type) -> None:
    """The field is a tuple of parts of one kind; a single part, or any iterable of them, is accepted."""
    value = getattr(scene, name)
    must = f"{name} must be a list of {kind.__name__} objects"
    if isinstance(value, kind):
        value = (value,)
    if isinstance(value, (str, bytes, dict)) or not isinstance(value, Iterable):
        refuse(scene, f"{must}, got {shown(value)}")
    parts = tuple(value)
    for place, part in enumerate(parts):
        if not isinstance(part, kind):
            refuse(scene, f"{must}, got {shown(part)} as {name}[{place}]; put it into its own list")
    if name == "sources" and not parts:
        refuse(scene, "sources must hold at least one Source, got none; write sources=[Source(...)]")
    store(scene, **{name: parts})
