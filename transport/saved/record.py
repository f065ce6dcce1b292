"""What a file of a run holds, written and read: the scene as JSON, all by which the run goes on, and what it found out.

The suffix decides: .nc is NetCDF-4, .npz a zip of arrays.  Nothing in it is run when it is read: no pickle.
"""

from __future__ import annotations

import json
import zlib
from dataclasses import replace
from os import PathLike
from pathlib import Path
from zipfile import BadZipFile

from transport.compile.plan import Plan
from transport.estimators.aimed import unaimed_scene
from transport.results.batches import Batch
from transport.results.packed import Packed
from transport.results.result import Result
from transport.runs.machines import plan_for
from transport.runs.origins import this_origin
from transport.runs.state import State
from transport.saved import netcdf, npz
from transport.saved.columns import Columns, columns_of, values_of
from transport.saved.plain import Pool, meant, plain
from transport.saved.tables import tables_of
from transport.saved.whole import FileError, check_writable, written_whole
from transport.scene import Scene
from transport.validation import SceneError, shown

FORMAT, VERSION = "transport run", 1
NUL = "\0"
SUFFIXES = (".nc", ".npz")
KINDS = {"Batch": Batch, "Packed": Packed}  # of which columns are made
NOT_WHOLE = (
    OSError,
    KeyError,
    ValueError,
    TypeError,
    EOFError,
    MemoryError,
    RuntimeError,
    OverflowError,
    AttributeError,
    IndexError,
    BadZipFile,
    zlib.error,
)


def save(result: Result, path: str | PathLike, scene: str | None = None, is_over: bool = True) -> None:
    """Write a run into a file, whole or not at all.

    scene: its text, where that is known;  is_over: whether to write what it found out as well, for other programs.
    Raises FileError for a file that cannot be written, SceneError for a scene that no file can hold.
    """
    path = checked_path("save", path)
    scene = scene_text(given_scene(result)) if scene is None else scene
    columns: Columns = {}
    about, batches = _about(result, columns)
    texts = {"run": about, "scene": scene}
    tables = tables_of(result, is_over)
    with written_whole(path) as file:
        if path.suffix == ".nc":
            netcdf.write(file, path, texts, columns, tables, batches)
        else:
            npz.write(file, texts, columns, tables)


def load(path: str | PathLike) -> Result:
    """The run that was saved, as `simulate` returned it: bit for bit.

    Raises FileError for what is no such file, or not whole, or of another version.
    """
    path = checked_path("load", path)
    opened = netcdf.opened if path.suffix == ".nc" else npz.opened
    try:
        with opened(path) as (text, pieces):
            about, scene = _checked(path, json.loads(text("run"))), text("scene")
            kept = about["columns"], "", about["batches"], pieces, KINDS
            batches = values_of(*kept)
            run = {name: meant(value, batches) for name, value in about["run"].items()}
    except SceneError:
        raise
    except FileNotFoundError:
        raise FileError(f"no file {path}") from None
    except NOT_WHOLE as error:
        raise FileError(f"{path} is not a whole file of a run ({type(error).__name__}: {error})") from error
    return _result(path, about["rows"], scene, run)


def scene_text(scene: Scene) -> str:
    """The scene as files of its runs hold it.  Raises SceneError for what no file can hold."""
    for part in (*scene.sources, *scene.surfaces, *scene.detectors):
        name = getattr(part, "name", None) or ""
        if NUL in name:
            must, cure = "name must have no zero character, which ends a text in HDF5", name.replace(NUL, "_")
            raise SceneError(f"save: {type(part).__name__} {name!r}: {must}; write name={cure!r}")
    return scene.to_json()


def checked_path(what: str, path: object) -> Path:
    """The path, if its suffix is one of those that decide.  Raises SceneError, or FileError where a package is missing."""
    if not isinstance(path, str | PathLike):
        raise SceneError(
            f"{what}: must be the path of a file, got {shown(path)}; write 'run.nc' or 'run.npz'"
        )
    path = Path(path)
    if path.suffix not in SUFFIXES:
        cure = (
            f"write {path.with_suffix('.nc').name!r} or {path.with_suffix('.npz').name!r}"
            if path.name
            else "name one"
        )
        raise SceneError(f"{what}: a file of a run ends in .nc or .npz, got {str(path)!r}; {cure}")
    if path.suffix == ".nc":
        netcdf.h5netcdf_for(path)
    return path


def checked_place(what: str, path: object) -> Path:
    """The path, if a run may be saved there once it is over: asked before it begins, as a day later is too late.

    Raises as `checked_path`, and FileError where the folder is missing or may not be written to.
    """
    path = checked_path(what, path)
    if not path.parent.is_dir():
        raise FileError(f"{what} {path} is in no folder; make {path.parent} first")
    try:
        check_writable(path)
    except OSError as error:
        said = error.strerror or error
        raise FileError(f"{what} {path} cannot be written: {said}; name another file or folder") from None
    return path


def check_new(what: str, path: Path, overwrite: bool) -> None:
    """Raises FileError for a file that is there, unless that may be replaced."""
    if path.exists() and not overwrite:
        raise FileError(f"{what}: {path} is there; say --overwrite to replace it, or name another file")


def _about(result: Result, columns: Columns) -> tuple[str, int]:
    """All but the columns and the scene as JSON text, and how many batches these are of."""
    pool = Pool()
    run = {
        "seed": result.seed,
        "method": result.plan.method,
        "tracking": result.asked,
        "choice": result.choice,
        "is_complete": result.is_complete,
        "warnings": result._warnings,
        "cost": result.cost,
        "batches": result.batches,
        "state": state_of(result),
    }
    told = {name: plain(value, pool) for name, value in run.items()}
    about = {
        "format": FORMAT,
        "version": VERSION,
        "rows": rows_of(result.plan),
        "run": told,
        "batches": len(pool.batches),
        "columns": columns_of("", pool.batches, columns),
    }
    return json.dumps(about, ensure_ascii=False), len(pool.batches)


def _checked(path: Path, about: dict) -> dict:
    """What a file is about, if it is of a run and of a version that is known.  Raises FileError otherwise."""
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise FileError(
            f"{path} is no file of a run: its format is {shown(about.get('format'))}, not {FORMAT!r}"
        )
    if about["version"] > VERSION:
        raise FileError(
            f"{path}: its version {about['version']} is newer than {VERSION}, the newest known here; update transport"
        )
    return about


def _result(path: Path, rows: dict, scene: str, run: dict) -> Result:
    try:
        scene = Scene.from_json(scene)
    except SceneError as error:
        raise FileError(f"{path}: its scene: {error}") from error
    plan = plan_for(scene, run["tracking"], run["method"])
    if rows != rows_of(plan):
        made = ", ".join(f"{origin.version} ({origin.sources})" for origin in run["state"].origins)
        cure = "load it there, or read what it found out with xarray or numpy"
        raise FileError(f"{path} was made by transport {made}, whose sums are laid out otherwise; {cure}")
    return Result(
        plan,
        run["batches"],
        run["seed"],
        run["cost"],
        run["is_complete"],
        run["warnings"],
        run["tracking"],
        run["choice"],
        run["state"],
    )


def given_scene(result: Result) -> Scene:
    """The scene as `simulate` was given it."""
    return unaimed_scene(result.scene) if result.plan.method.estimator == "aimed" else result.scene


def rows_of(plan: Plan) -> dict[str, object]:
    """How a batch's sums are laid out."""
    numbers = ("rows", "half", "long_rows", "volume_rows", "point_rows", "cell_rows", "size_cells")
    return {name: int(getattr(plan, name)) for name in numbers} | {"bases": dict(plan.bases)}


def state_of(result: Result) -> State:
    """By what the run goes on, with who did its batches.  Raises SceneError where it cannot go on."""
    if result.state is None:
        raise SceneError(
            "save: this result is none that simulate, load or merge returned; save one of theirs"
        )
    return replace(result.state, origins=result.state.origins or (this_origin(),))
