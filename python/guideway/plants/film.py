"""Pictures of a run in the simulator: a film as GIF, a still as PNG."""

from __future__ import annotations

import ctypes.util
import importlib
import io
import math
import os
import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from guideway.files import write_whole

if TYPE_CHECKING:
    from guideway.plants.mujoco import MobileBase

RATE = 12.5
"""Pictures per second of a film; a long run has fewer, so that there are at most :data:`MOST`."""
MOST = 250
FILM, STILL = (480, 300), (1280, 800)
"""Width and height, pixels."""
GHOSTS = 8
"""Bodies of before in a still picture."""
BLUE = (0.13, 0.45, 0.78, 1.0)

Frame = tuple[float, np.ndarray, np.ndarray]
"""Time (s), joints and movers."""


class NoPicture(RuntimeError):
    """Pictures cannot be made here; says why and what to do."""


def save(plant: MobileBase, path: str | os.PathLike[str], size: tuple[int, int] | None = None) -> None:
    """Writes the run so far: a film (``.gif``), or the room with the way it took and where it was at some moments (``.png``).

    Raises :class:`NoPicture` where nothing can be rendered, ``ValueError`` for another ending.
    """
    name = os.fspath(path).lower()
    if name.endswith(".gif"):
        write_whole(path, _gif(plant, size or FILM))
    elif name.endswith(".png"):
        write_whole(path, _png(plant, size or STILL))
    else:
        raise ValueError(f"{os.fspath(path)!r} has no ending that is known: .gif for a film, .png for a picture")


def pictures(plant: MobileBase, size: tuple[int, int], every: int = 1) -> Iterator[np.ndarray]:
    """Every so many states of the run as an image, ``(height, width, 3)``."""
    chosen = [*plant.frames[:-1:every], plant.frames[-1]]
    with _renderer(plant, size, shadows=False) as picture:
        for count, frame in enumerate(chosen):
            yield picture(frame, [frame[1][:2] for frame in chosen[: count + 1]], [])


def still(plant: MobileBase, size: tuple[int, int]) -> np.ndarray:
    """The room at the end, the way that was taken, and the body where it was at some moments before; ``(height, width, 3)``."""
    frames = plant.frames
    way = [frame[1][:2] for frame in frames[:: max(1, len(frames) // 300)]]
    with _renderer(plant, size, shadows=True) as picture:
        return picture(frames[-1], way, [frames[k] for k in _moments(frames)])


def _moments(frames: Sequence[Frame]) -> list[int]:
    """Some states at equal distances along the way, without the last."""
    way = np.concatenate([[0.0], np.cumsum([np.hypot(*(b[1][:2] - a[1][:2])) for a, b in pairwise(frames)])])
    at = np.linspace(0.0, way[-1], GHOSTS + 2)[:-1]
    return sorted({int(k) for k in np.searchsorted(way, at)} - {len(frames) - 1})


def _screen(mujoco: Any, size: tuple[int, int]) -> Any:
    """Where to draw: what MUJOCO_GL asks for, else the screen there is, else memory."""
    headless = sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if "MUJOCO_GL" in os.environ or not headless:
        return mujoco.GLContext(*size)
    for library in ("EGL", "OSMesa"):
        if ctypes.util.find_library(library):
            return importlib.import_module(f"mujoco.{library.lower()}").GLContext(*size)
    raise OSError("no screen, no EGL, no OSMesa")


class _renderer:
    """Draws states of a plant; closed whatever happens; :class:`NoPicture` where nothing can be rendered."""

    def __init__(self, plant: MobileBase, size: tuple[int, int], shadows: bool) -> None:
        self.mujoco, self.model = plant.simulator, plant.model
        self.data = self.mujoco.MjData(self.model)
        self.hull = self.mujoco.mj_name2id(self.model, self.mujoco.mjtObj.mjOBJ_GEOM, "hull")
        self.size = size
        self.scene = self.mujoco.MjvScene(self.model, maxgeom=2 * self.model.ngeom + 2000)
        self.scene.flags[self.mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        self.camera = view_of(self.mujoco, plant, size)
        try:
            self.screen = _screen(self.mujoco, size)
            self.screen.make_current()
            self.context = self.mujoco.MjrContext(self.model, self.mujoco.mjtFontScale.mjFONTSCALE_150.value)
        except Exception as error:  # whatever the graphics library of this machine raises
            raise NoPicture(
                f"this machine cannot render ({error or type(error).__name__}). Install EGL (libegl1, libgl1-mesa-dri) or OSMesa (libosmesa6), "
                "or set MUJOCO_GL"
            ) from error
        self.mujoco.mjr_setBuffer(self.mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self.context)

    def __enter__(self) -> _renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.context.free()
        self.screen.free()

    def __call__(self, frame: Frame, way: Sequence[np.ndarray], ghosts: Sequence[Frame]) -> np.ndarray:
        before = [self._place(ghost) for ghost in ghosts]
        self._place(frame)
        everything = self.mujoco.mjtCatBit.mjCAT_ALL.value
        self.mujoco.mjv_updateScene(self.model, self.data, self.mujoco.MjvOption(), None, self.camera, everything, self.scene)
        kinds = self.mujoco.mjtGeom
        for a, b in pairwise(way):
            if np.hypot(*(b - a)) > 1e-4:
                geom = self._add(kinds.mjGEOM_CAPSULE, BLUE)
                self.mujoco.mjv_connector(geom, kinds.mjGEOM_CAPSULE, 0.02, np.array([*a, 0.01]), np.array([*b, 0.01]))
        for place, turn in before:
            geom = self._add(int(self.model.geom_type[self.hull]), (*BLUE[:3], 0.3), self.model.geom_size[self.hull], place, turn)
            geom.dataid = 2 * int(self.model.geom_dataid[self.hull])
        pixels = np.empty((self.size[1], self.size[0], 3), dtype=np.uint8)
        place = self.mujoco.MjrRect(0, 0, *self.size)
        self.mujoco.mjr_render(place, self.scene, self.context)
        self.mujoco.mjr_readPixels(pixels, None, place, self.context)
        return np.flipud(pixels)

    def _place(self, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
        """Puts everything where it was; returns where the body is then."""
        _, self.data.qpos[:], self.data.mocap_pos[:] = frame
        self.mujoco.mj_kinematics(self.model, self.data)
        self.mujoco.mj_camlight(self.model, self.data)
        return self.data.geom_xpos[self.hull].copy(), self.data.geom_xmat[self.hull].copy()

    def _add(self, kind: Any, colour: Sequence[float], size: Any = (0, 0, 0), place: Any = (0, 0, 0), turn: Any = (0,) * 9) -> Any:
        """One more thing in the picture."""
        scene = self.scene
        geom = scene.geoms[scene.ngeom]
        arrays = [np.asarray(values, dtype=np.float64) for values in (size, place, turn)]
        self.mujoco.mjv_initGeom(geom, kind, *arrays, np.asarray(colour, dtype=np.float32))
        scene.ngeom += 1
        return geom


def view_of(mujoco: Any, plant: MobileBase, size: tuple[int, int]) -> Any:
    """A camera that sees the whole room from the south, from above."""
    left, low, right, high = plant.bounds
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (left + right) / 2, (low + high) / 2 - 0.03 * (high - low), 0.0
    camera.azimuth, camera.elevation = 90.0, -58.0
    half = math.radians(float(plant.model.vis.global_.fovy)) / 2
    wide = (right - left + 1.2) / 2 / (math.tan(half) * size[0] / size[1])
    deep = (high - low + 1.2) / 2 * math.sin(math.radians(58.0)) / math.tan(half)
    camera.distance = max(wide, deep) + 0.32 * (high - low)
    return camera


def _gif(plant: MobileBase, size: tuple[int, int]) -> bytes:
    from guideway.plants.mujoco import FRAMES

    every = max(round(FRAMES / RATE), -(-len(plant.frames) // MOST))
    images = [Image.fromarray(pixels) for pixels in pictures(plant, size, every)]
    palette = images[len(images) // 2].quantize(96, method=Image.Quantize.MEDIANCUT)
    small = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    buffer = io.BytesIO()
    duration = [round(1000 * every / FRAMES)] * (len(small) - 1) + [1500]
    small[0].save(buffer, "GIF", save_all=True, append_images=small[1:], duration=duration, loop=0, optimize=False, disposal=1)
    return buffer.getvalue()


def _png(plant: MobileBase, size: tuple[int, int]) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(still(plant, size)).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()
