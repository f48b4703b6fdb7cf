"""Alembic: one file for all frames, with points, the surface of the snow, and the solids."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from neve.export.camera import NAME as CAMERA
from neve.export.format import NAME, Format, Job, made_by_library, require
from neve.export.moment import Moment
from neve.export.solids import SolidSurface
from neve.io.errors import RunError

FILE = f"{NAME}.abc"
SURFACE = f"{NAME}_surface"


class Alembic(Format):
    """Write `snow.abc`: points `snow`, a mesh `snow_surface`, a mesh below a transform for each solid,
    and `camera`, a transform with the camera `lens` below it.

    Points have velocities [units/s], widths (one spacing), ids, and other fields as arbitrary parameters. The
    time of a sample is its frame's number over the frames in a second.
    """

    up = "y"
    takes_matrices = False
    whole = True
    package = ("alembic3d", "alembic3d")

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        library = require("alembic3d", "alembic3d")
        self._abc, self._geom, self._core = library.Abc, library.AbcGeom, library.AbcCoreAbstract
        self._imath = require("imath", "alembic3d")
        self._stack = contextlib.ExitStack()
        self._open: _Open | None = None

    def names(self, frame: int) -> tuple[str, ...]:
        """Return the name of the one file."""
        return (FILE,)

    def begin(self, frames: Sequence[int]) -> None:
        """Start the file, which will have samples of these frames."""
        place = self._stack.enter_context(made_by_library(self.path(FILE)))
        with self._refusals():
            self._open = _Open(self, str(place), frames)

    def write(self, moment: Moment) -> None:
        """Add the samples of a frame."""
        assert self._open is not None
        with self._refusals():
            self._open.add(moment)

    def __enter__(self) -> Self:
        self._stack.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._open = None  # the library finishes the file when the last that belongs to it is gone
        self._stack.__exit__(kind, error, trace)

    @contextlib.contextmanager
    def _refusals(self) -> Iterator[None]:
        """Turn what the library refuses in the block into one sentence. Errors: RunError."""
        try:
            yield
        except RuntimeError as error:
            if isinstance(error, RunError):
                raise
            raise RunError(
                f"{self.path(FILE)} could not be written: {str(error).splitlines()[0]}."
            ) from error

    # What the library is given

    def vectors(self, x: NDArray[Any]) -> Any:
        """Return vectors (n, 3) as an array of the library."""
        return self._imath.V3fArrayFromBuffer(np.ascontiguousarray(x, np.float32))

    def whole_numbers(self, values: NDArray[Any]) -> Any:
        """Return whole numbers (n,) as an array of the library."""
        return self._imath.IntArrayFromBuffer(np.ascontiguousarray(values, np.int32))

    def numbers(self, values: NDArray[Any]) -> Any:
        """Return numbers (n,) as an array of the library."""
        return self._imath.FloatArrayFromBuffer(np.ascontiguousarray(values, np.float32))


class _Open:
    """Hold the file while it is written."""

    def __init__(self, owner: Alembic, place: str, frames: Sequence[int]) -> None:
        geom = owner._geom
        self._owner = owner
        self._archive = owner._abc.OArchive(place)
        self._times = self._archive.addTimeSampling(_sampling(owner._core, frames, owner.job.fps))
        top = self._archive.getTop()
        self._points = geom.OPoints(top, NAME, self._times)
        self._surface = geom.OPolyMesh(top, SURFACE, self._times)
        self._camera = geom.OXform(top, CAMERA, self._times)
        self._lens = geom.OCamera(self._camera, "lens", self._times)
        self._fields: dict[str, Any] = {}
        self._poses = {i: self._add_solid(top, i, surface) for i, surface in owner.solids}

    def add(self, moment: Moment) -> None:
        """Add the samples of a frame."""
        from neve.surface.mesh import snow_surface

        owner, geom = self._owner, self._owner._geom
        widths = owner.numbers(np.full(len(moment.x), owner.job.spacing))
        vertex = geom.GeometryScope.kVertexScope
        sample = geom.OPointsSchemaSample(
            owner.vectors(moment.x),
            owner.whole_numbers(moment.id),
            owner.vectors(moment.v),
            geom.OFloatGeomParamSample(widths, vertex),
        )
        self._points.getSchema().set(sample)
        for name, values in moment.fields.items():
            if name not in ("v", "id"):
                self._add_field(name, values, vertex)
        snow = snow_surface(moment.x, owner.job.spacing, v=moment.v)
        self._surface.getSchema().set(self._mesh(snow.vertices, snow.faces, snow.normals, snow.velocity))
        self._add_camera(moment.time)
        for i, (place, still) in self._poses.items():
            if place is not None:
                place.set(self._pose(moment.poses[i]))
                if still:
                    self._poses[i] = (None, True)

    def _pose(self, matrix: NDArray[np.float64]) -> Any:
        """Return a transform (4, 4) as a sample."""
        pose = self._owner._geom.XformSample()
        pose.setMatrix(self._owner._imath.M44d(*(float(c) for c in matrix.T.ravel())))
        return pose

    def _add_camera(self, time: float) -> None:
        """Add the camera at a time [s]: the focal length is in millimetres, the film in centimetres."""
        ours, sample = self._owner.job.camera, self._owner._geom.CameraSample()
        pose, unit = ours.at(time), self._owner.job.axes.scale
        self._camera.getSchema().set(self._pose(pose.matrix))
        sample.setFocalLength(1000.0 * ours.focal_length(pose) / unit)
        sample.setHorizontalAperture(100.0 * ours.width / unit)
        sample.setVerticalAperture(100.0 * ours.height / unit)
        sample.setNearClippingPlane(pose.clipping[0])
        sample.setFarClippingPlane(pose.clipping[1])
        sample.setFocusDistance(pose.focus)
        sample.setFStop(ours.f_number(pose))
        half = 0.5 * ours.shutter / self._owner.job.fps
        sample.setShutterOpen(-half)
        sample.setShutterClose(half)
        self._lens.getSchema().set(sample)

    def _add_field(self, name: str, values: NDArray[Any], vertex: Any) -> None:
        geom = self._owner._geom
        if values.ndim == 2:
            kind, array = "V3f", self._owner.vectors(values)
        elif values.dtype.kind in "iu":
            kind, array = "Int32", self._owner.whole_numbers(values)
        else:
            kind, array = "Float", self._owner.numbers(values)
        if name not in self._fields:
            parent = self._points.getSchema().getArbGeomParams()
            made = getattr(geom, f"O{kind}GeomParam")(parent, name, False, vertex, 1)
            made.setTimeSampling(self._times)
            self._fields[name] = made
        self._fields[name].set(getattr(geom, f"O{kind}GeomParamSample")(array, vertex))

    def _add_solid(self, top: Any, i: int, surface: SolidSurface) -> tuple[Any, bool]:
        """Add the mesh of a solid; return its transform, and whether the first sample of it is all."""
        geom = self._owner._geom
        still = self._owner.job.solids[i].motion == "static"
        place = geom.OXform(top, surface.word, 0 if still else self._times)
        mesh = geom.OPolyMesh(place, "mesh")
        mesh.getSchema().set(self._mesh(surface.vertices, surface.faces))
        return place.getSchema(), still

    def _mesh(
        self,
        vertices: NDArray[Any],
        faces: NDArray[Any],
        normals: NDArray[Any] | None = None,
        velocity: NDArray[Any] | None = None,
    ) -> Any:
        """Return a sample of a mesh; corners go clockwise from outside, as the format has it."""
        owner, geom = self._owner, self._owner._geom
        corners = owner.whole_numbers(faces[:, ::-1].reshape(-1))
        counts = owner.whole_numbers(np.full(len(faces), 3))
        sample = geom.OPolyMeshSchemaSample(owner.vectors(vertices), corners, counts)
        if normals is not None:
            shared = geom.GeometryScope.kVertexScope
            sample.setNormals(geom.ON3fGeomParamSample(owner.vectors(normals), shared))
        if velocity is not None:
            sample.setVelocities(owner.vectors(velocity))
        return sample


def _sampling(core: Any, frames: Sequence[int], fps: int) -> Any:
    """Return the times of samples [s]: evenly spaced where the frames are."""
    steps = {b - a for a, b in itertools.pairwise(frames)} or {1}
    if len(steps) == 1:
        return core.TimeSampling(steps.pop() / fps, frames[0] / fps)
    times = core.TimeVector()
    times.extend([frame / fps for frame in frames])
    return core.TimeSampling(core.TimeSamplingType(core.AcyclicFlag.kAcyclic), times)
