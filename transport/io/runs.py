"""Save and load runs: the scene as JSON, the state of the run, and its results.

The suffix gives the format: .nc is NetCDF-4, .npz a zip of arrays.  Loading executes no code from the file:
no pickle.
"""

from __future__ import annotations

import glob
import json
from dataclasses import replace
from os import PathLike
from pathlib import Path

from transport.compile.methods import unaimed_scene
from transport.compile.plan import Plan
from transport.io import netcdf, npz
from transport.io.atomic import FileError, atomic_write, check_writable
from transport.io.columns import BatchPool, Columns, describe_columns, from_json, read_values, to_json
from transport.io.tables import result_tables
from transport.results.batches import Batch
from transport.results.result import Result
from transport.run.programs import plan_for
from transport.run.provenance import this_origin
from transport.run.state import State
from transport.scene.scene import Scene
from transport.statistics.packed import Packed
from transport.validation import SceneError, join_names, short_repr

FORMAT, VERSION = "transport run", 1
NUL = "\0"
SUFFIXES = (".nc", ".npz")
COLUMN_TYPES = {"Batch": Batch, "Packed": Packed}  # types stored as columns


def save(result: Result, path: str | PathLike, scene: str | None = None, is_over: bool = True) -> None:
    """Write a run to a file, atomically.

    `scene` is the text of the scene, if known.  `is_over` adds the results for other programs.  Raises
    FileError if the file cannot be written, SceneError for a scene that no file can hold.
    """
    path = checked_path("save", path)
    scene = scene_text(original_scene(result)) if scene is None else scene
    columns: Columns = {}
    about, batches = _metadata(result, columns)
    texts = {"run": about, "scene": scene}
    tables = result_tables(result, is_over)
    with atomic_write(path) as file:
        if path.suffix == ".nc":
            netcdf.write_run(file, path, texts, columns, tables, batches)
        else:
            npz.write_run(file, texts, columns, tables)


def load(path: str | PathLike) -> Result:
    """Load a saved run, bit for bit as `simulate` returned it.

    Raises FileError for a missing or damaged file, and for a file of another version.
    """
    path = checked_path("load", path)
    opened = netcdf.open_run if path.suffix == ".nc" else npz.open_run
    try:
        with opened(path) as (text, pieces):
            about, scene = _checked_metadata(path, json.loads(text("run"))), text("scene")
            kept = about["columns"], "", about["batches"], pieces, COLUMN_TYPES
            batches = read_values(*kept)
            run = {name: from_json(value, batches) for name, value in about["run"].items()}
    except SceneError:
        raise
    except FileNotFoundError:
        raise FileError(f"no file {path}{_numbered_files(path)}") from None
    except Exception as error:  # a damaged file raises what its readers never expected
        why = f"{type(error).__name__}: {error}"
        raise FileError(f"{path} is not a complete file of a run ({why})") from error
    return _make_result(path, about["rows"], scene, run)


def scene_text(scene: Scene) -> str:
    """Return the scene as text for a file.  Raises SceneError for a scene that no file can hold."""
    for part in (*scene.sources, *scene.surfaces, *scene.detectors):
        name = getattr(part, "name", None) or ""
        if NUL in name:
            must, cure = "name must have no zero character, which ends a text in HDF5", name.replace(NUL, "_")
            raise SceneError(f"save: {type(part).__name__} {name!r}: {must}; write name={cure!r}")
    return scene.to_json()


def checked_path(what: str, path: object) -> Path:
    """Return the path.  Raises SceneError for a wrong suffix, FileError if a package is missing."""
    if not isinstance(path, str | PathLike):
        raise SceneError(
            f"{what}: must be the path of a file, got {short_repr(path)}; write 'run.nc' or 'run.npz'"
        )
    path = Path(path)
    if path.suffix not in SUFFIXES:
        named = " or ".join(repr(path.with_suffix(suffix).name) for suffix in SUFFIXES) if path.name else ""
        cure = f"write {named}" if named else "name a file"
        raise SceneError(f"{what}: the file of a run ends in .nc or .npz, got {str(path)!r}; {cure}")
    if path.suffix == ".nc":
        netcdf.require_h5netcdf(path)
    return path


def checked_destination(what: str, path: object) -> Path:
    """Return the path if a run can be saved there; checked before the run starts, not after a day.

    Raises like `checked_path`, and FileError if the folder is missing or not writable.
    """
    path = checked_path(what, path)
    if not path.parent.is_dir():
        raise FileError(f"{what} {path}: the folder does not exist; make {path.parent} first")
    try:
        check_writable(path)
    except OSError as error:
        reason = error.strerror or error
        raise FileError(f"{what} {path} cannot be written: {reason}; name another file or folder") from None
    return path


def check_not_existing(what: str, path: Path, overwrite: bool) -> None:
    """Raise FileError if the file exists and must not be replaced."""
    if path.exists() and not overwrite:
        raise FileError(f"{what}: {path} exists; pass --overwrite to replace it, or name another file")


def _metadata(result: Result, columns: Columns) -> tuple[str, int]:
    """Return the run without columns and scene as JSON text, and its number of batches."""
    pool = BatchPool()
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
    fields = {name: to_json(value, pool) for name, value in run.items()}
    about = {
        "format": FORMAT,
        "version": VERSION,
        "rows": sum_layout(result.plan),
        "run": fields,
        "batches": len(pool.batches),
        "columns": describe_columns("", pool.batches, columns),
    }
    return json.dumps(about, ensure_ascii=False), len(pool.batches)


def _checked_metadata(path: Path, about: dict) -> dict:
    """Return the data of a file.  Raises FileError if it is not the file of a run, or of a newer version."""
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        got = short_repr(about.get("format"))
        raise FileError(f"{path} is not the file of a run: its format is {got}, not {FORMAT!r}")
    if (version := about["version"]) > VERSION:
        newest = f"{VERSION}, the newest known here; update transport"
        raise FileError(f"{path}: its version {version} is newer than {newest}")
    return about


def _numbered_files(path: Path) -> str:
    """Return a hint at the files of an experiment's cases, which are saved under numbered names."""
    found = sorted(file.name for file in path.parent.glob(f"{glob.escape(path.stem)}_[0-9]*{path.suffix}"))
    return f"; the cases of an experiment have a file each: {join_names(found)}" if found else ""


def _make_result(path: Path, rows: dict, scene: str, run: dict) -> Result:
    try:
        scene = Scene.from_json(scene)
    except SceneError as error:
        raise FileError(f"{path}: scene: {error}") from error
    plan = plan_for(scene, run["tracking"], run.pop("method"))
    if rows != sum_layout(plan):
        made = ", ".join(f"{origin.version} ({origin.sources})" for origin in run["state"].origins)
        cure = "load it with that version, or read its results with xarray or numpy"
        raise FileError(f"{path} was made by transport {made}, which lays out its sums differently; {cure}")
    return Result(plan, asked=run.pop("tracking"), **run)


def original_scene(result: Result) -> Scene:
    """Return the scene as it was passed to `simulate`."""
    return unaimed_scene(result.scene) if result.plan.method.estimator == "aimed" else result.scene


def sum_layout(plan: Plan) -> dict[str, object]:
    """Return the layout of a batch's sums."""
    numbers = {name: int(getattr(plan, name)) for name in ("rows", "half", "long_rows", "size_cells")}
    kinds = {"volume_rows": plan.scene.volumes, "point_rows": plan.scene.points}
    counts = {name: sum(plan.rows_of[each.name].count for each in found) for name, found in kinds.items()}
    counts["volume_rows"] += sum(rows.count for rows in plan.absorbed_rows_of.values())
    counts["cell_rows"] = plan.rows_of["cells"].count if plan.adjoint is not None else 0
    return numbers | counts | {"bases": {name: rows.base for name, rows in plan.rows_of.items()}}


def state_of(result: Result) -> State:
    """Return the state from which a run continues, with its origins.  Raises SceneError if it has none."""
    if result.state is None:
        raise SceneError(
            "save: this result has no state to continue from; save a result of simulate, load or merge"
        )
    return replace(result.state, origins=result.state.origins or (this_origin(),))
