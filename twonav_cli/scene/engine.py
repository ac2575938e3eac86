"""The one import of MuJoCo: how it draws is chosen first, because it is fixed when MuJoCo is imported."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import sys

from twonav_cli.errors import TwonavError

RENDERER_VARIABLE = "MUJOCO_GL"


def _loads(library: str) -> bool:
    """Whether a shared library is there and can be loaded."""
    found = ctypes.util.find_library(library)
    if found is None:
        return False
    try:
        ctypes.CDLL(found)
    except OSError:
        return False
    return True


RENDERER_PACKAGES = "libegl1 libopengl0 libgl1 libgl1-mesa-dri"
"""Debian's packages of EGL and Mesa's software driver; install_renderer.sh installs the same."""


def install_command() -> str:
    """Return what to type on a Debian-like system that cannot draw without a screen."""
    sudo = "" if not hasattr(os, "geteuid") or os.geteuid() == 0 else "sudo "
    return f"{sudo}apt-get install -y --no-install-recommends {RENDERER_PACKAGES}"


def choose_renderer() -> str:
    """Choose how MuJoCo draws, unless MUJOCO_GL says so already: on a screen, else EGL, else OSMesa.

    Returns:
        The value of MUJOCO_GL; empty where MuJoCo's own choice is right (a screen, macOS, Windows).

    Raises:
        TwonavError: There is nothing to draw with; the message holds the command that changes it.
    """
    preset = os.environ.get(RENDERER_VARIABLE, "").strip()
    on_screen = bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if preset or on_screen or sys.platform != "linux":
        return preset
    for name, library in (("egl", "EGL"), ("osmesa", "OSMesa")):
        if _loads(library):
            os.environ[RENDERER_VARIABLE] = name
            return name
    raise TwonavError(f"the camera has nothing to draw with: type `{install_command()}` and try again")


def _choose_quietly() -> None:
    """Choose before the import below; whoever needs no picture can go on without a renderer."""
    try:
        choose_renderer()
    except TwonavError:
        return


_choose_quietly()

try:
    import mujoco
except (ImportError, AttributeError, OSError, RuntimeError) as error:
    raise TwonavError(
        f"MuJoCo cannot start with {RENDERER_VARIABLE}={os.environ.get(RENDERER_VARIABLE, '')!r} "
        f"({str(error).splitlines()[0]}): unset {RENDERER_VARIABLE}, or type `{install_command()}`"
    ) from error

__all__ = ["choose_renderer", "install_command", "mujoco"]
