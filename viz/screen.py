"""Whether 3-D pictures can be drawn here: asked once, of a child process, because a missing library kills the one who asks."""

from __future__ import annotations

import functools
import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from transport.validation import pip_install

PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.Render()
print("drawn", window.GetClassName())
"""
PATIENCE = 60  # seconds
NO_LIBRARIES = (
    "3-D pictures need the libraries of OpenGL, which this machine lacks; on Debian or Ubuntu install two packages:"
    " sudo apt-get install -y libegl1 libgl1-mesa-dri   (all else works without: tables, charts, results)"
)
NO_PYVISTA = f"3-D pictures need pyvista, which is not installed; {pip_install('viz')}"


class NoScreen(Exception):
    """3-D pictures cannot be drawn here; its words say what to install."""


def has_display() -> bool:
    """Whether there is a display that a window can open on."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def make_ready() -> None:
    """Let VTK draw without a display; to be called before pyvista is first imported."""
    if not has_display():
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def require_screen() -> None:
    """Make ready to draw with VTK; to be called before pyvista is first imported.  Raises NoScreen where it cannot."""
    make_ready()
    lack = _lack()
    if lack is not None:
        raise NoScreen(lack)


def has_screen() -> bool:
    """Whether 3-D pictures can be drawn here."""
    try:
        require_screen()
    except NoScreen:
        return False
    return True


@contextmanager
def without_screen() -> Iterator[None]:
    """Windows that nothing is drawn on may be made here, on any machine; VTK keeps to itself what it lacks for more."""
    make_ready()
    from vtkmodules.vtkCommonCore import vtkLogger

    spoken = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(spoken)


@functools.cache
def _lack() -> str | None:
    """What is missing, in words; None where a child process has drawn an empty picture."""
    if importlib.util.find_spec("pyvista") is None:
        return NO_PYVISTA
    try:
        done = subprocess.run(
            [sys.executable, "-c", PROBE], capture_output=True, text=True, timeout=PATIENCE, check=False
        )
    except subprocess.TimeoutExpired:
        return NO_LIBRARIES
    return None if done.returncode == 0 and "drawn" in done.stdout else NO_LIBRARIES
