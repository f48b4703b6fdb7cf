"""USD: particles as points and solids as meshes, a layer for each frame, put together by value clips.

`snow.usda` is the stage to open. The layers of the frames hold what changes; a program reads only the one
that it shows (value clips: openusd.org, "Sequencable, Re-timeable Animated Value Clips").
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.export.format import NAME, Format, Job, made_by_library, replacing, require
from neve.export.moment import Moment
from neve.export.solids import SolidSurface
from neve.io.errors import RunError

WORLD = "/World"
SNOW = f"{WORLD}/Snow"
CAMERA = f"{WORLD}/Camera"
SOLIDS = "solids.usdc"
MANIFEST = "snow_manifest.usda"
WHITE = (0.93, 0.95, 0.98)
"""Colour of snow for programs that show no material, linear."""

Attribute = tuple[str, str, Any]
"""Path of a prim, name of an attribute, and its type."""


class Usd(Format):
    """Write `snow.usda`, its manifest of clips, `solids.usdc`, and `snow_NNNNNN.usdc` for each frame.

    The stage has the scene's camera, a sample for each frame.
    Points have velocities [units/s], widths (one spacing), ids and extent; other fields are primvars, a
    matrix transposed, as USD multiplies rows from the left. Time codes are numbers of frames.
    """

    ending = "usdc"
    package = ("pxr.Usd", "usd-core")

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        self._pxr = {
            name: require(f"pxr.{name}", "usd-core") for name in ("Gf", "Sdf", "Tf", "UsdGeom", "Vt")
        }
        self._usd = require("pxr.Usd", "usd-core")
        self._began = False

    def shared_names(self) -> tuple[str, ...]:
        """Return the names of the stage, of its manifest, and of the solids."""
        return (f"{NAME}.usda", MANIFEST, *([SOLIDS] if self.solids else []))

    def write(self, moment: Moment) -> None:
        """Write the layer of a frame, and the solids if this is the first one."""
        if self.solids and not self._began:
            self._write_solids(moment)
        self._began = True
        with self._stage(self.path(self.names(moment.frame)[0])) as stage:
            for (path, name, kind), value in self._values(moment).items():
                attribute = self._declare(stage, path, name, kind)
                attribute.Set(value, moment.frame)

    def close(self, times: Mapping[int, float]) -> None:
        """Write the stage and the manifest of its clips."""
        first = self._first_layer(times)
        if first is None:
            return
        attributes = self._attributes(first)
        self._write_text(MANIFEST, lambda stage: self._declare_all(stage, attributes))
        below = (f"./{SOLIDS}",) if self.solids else ()
        self._write_text(f"{NAME}.usda", lambda stage: self._put_together(stage, attributes, times), below)

    def _values(self, moment: Moment) -> dict[Attribute, Any]:
        """Return what changes from frame to frame: attributes and their values."""
        Sdf, Vt = self._pxr["Sdf"], self._pxr["Vt"]
        kinds, x = Sdf.ValueTypeNames, moment.x
        half = 0.5 * self.job.spacing
        box = np.stack([x.min(axis=0) - half, x.max(axis=0) + half]) if len(x) else np.zeros((2, 3))
        widths = np.full(len(x), self.job.spacing, np.float32)
        values: dict[Attribute, Any] = {
            (SNOW, "points", kinds.Point3fArray): vectors(Vt, x),
            (SNOW, "velocities", kinds.Vector3fArray): vectors(Vt, moment.v),
            (SNOW, "widths", kinds.FloatArray): Vt.FloatArray.FromNumpy(widths),
            (SNOW, "ids", kinds.Int64Array): Vt.Int64Array.FromNumpy(moment.id.astype(np.int64)),
            (SNOW, "extent", kinds.Float3Array): vectors(Vt, box.astype(np.float32)),
        }
        for name, field in moment.fields.items():
            if name not in ("v", "id"):
                kind, value = self._primvar(field)
                values[SNOW, f"primvars:{name}", kind] = value
        for i, surface in self.solids:
            if self.job.solids[i].motion != "static":
                matrix = self._pxr["Gf"].Matrix4d(moment.poses[i].T.tolist())
                values[solid_path(surface), "xformOp:transform", kinds.Matrix4d] = matrix
        return values

    def _primvar(self, field: NDArray[Any]) -> tuple[Any, Any]:
        """Return type and value of a field as USD has them."""
        Vt, kinds = self._pxr["Vt"], self._pxr["Sdf"].ValueTypeNames
        if field.ndim == 3:
            rows = np.ascontiguousarray(field.transpose(0, 2, 1), np.float64)
            return kinds.Matrix3dArray, Vt.Matrix3dArray.FromNumpy(rows)
        if field.ndim == 2:
            return kinds.Vector3fArray, vectors(Vt, field)
        if field.dtype.kind in "iu":
            return kinds.IntArray, Vt.IntArray.FromNumpy(field.astype(np.int32))
        return kinds.FloatArray, Vt.FloatArray.FromNumpy(np.ascontiguousarray(field, np.float32))

    def _declare(self, stage: Any, path: str, name: str, kind: Any) -> Any:
        """Return the attribute, declared on an `over` where the prim is not defined yet."""
        attribute = stage.OverridePrim(path).CreateAttribute(name, kind, custom=False)
        if name.startswith("primvars:") or name == "widths":
            attribute.SetMetadata("interpolation", "vertex")
        return attribute

    def _declare_all(self, stage: Any, attributes: list[Attribute]) -> None:
        for path, name, kind in attributes:
            self._declare(stage, path, name, kind)

    def _first_layer(self, times: Mapping[int, float]) -> Any:
        names = [self.names(frame)[0] for frame in times]
        return self._pxr["Sdf"].Layer.OpenAsAnonymous(str(self.path(names[0]))) if names else None

    def _attributes(self, layer: Any) -> list[Attribute]:
        """Return the attributes that the layer of a frame has."""
        found: list[Attribute] = []

        def visit(path: Any) -> None:
            if path.IsPropertyPath():
                spec = layer.GetAttributeAtPath(path)
                found.append((str(path.GetPrimPath()), path.name, spec.typeName))

        layer.Traverse(WORLD, visit)
        return sorted(found, key=lambda attribute: attribute[:2])

    def _put_together(self, stage: Any, attributes: list[Attribute], times: Mapping[int, float]) -> None:
        """Make the stage: its metadata, points, transforms of solids, the clips of the frames, the camera."""
        frames = list(times)
        geom, Sdf = self._pxr["UsdGeom"], self._pxr["Sdf"]
        self._describe(stage)
        world = geom.Xform.Define(stage, WORLD).GetPrim()
        stage.SetStartTimeCode(frames[0])
        stage.SetEndTimeCode(frames[-1])
        points = geom.Points.Define(stage, SNOW)
        points.CreateDisplayColorAttr([WHITE])
        self._declare_all(stage, attributes)
        clips = self._usd.ClipsAPI(world)
        clips.SetClipAssetPaths([Sdf.AssetPath(f"./{self.names(frame)[0]}") for frame in frames])
        clips.SetClipPrimPath(WORLD)
        clips.SetClipManifestAssetPath(Sdf.AssetPath(f"./{MANIFEST}"))
        clips.SetClipActive([(float(frame), float(k)) for k, frame in enumerate(frames)])
        clips.SetClipTimes([(float(frame), float(frame)) for frame in frames])
        self._add_camera(stage, times)

    def _add_camera(self, stage: Any, times: Mapping[int, float]) -> None:
        """Make the camera, a sample for each frame; lengths of lens and film are tenths of a unit."""
        geom, Gf, ours = self._pxr["UsdGeom"], self._pxr["Gf"], self.job.camera
        camera = geom.Camera.Define(stage, CAMERA)
        camera.CreateProjectionAttr("perspective")
        camera.CreateHorizontalApertureAttr(10.0 * ours.width)
        camera.CreateVerticalApertureAttr(10.0 * ours.height)
        camera.CreateShutterOpenAttr(-0.5 * ours.shutter)
        camera.CreateShutterCloseAttr(0.5 * ours.shutter)
        place = camera.AddTransformOp()
        for frame, time in times.items():
            pose = ours.at(time)
            place.Set(Gf.Matrix4d(pose.matrix.T.tolist()), frame)
            camera.CreateFocalLengthAttr().Set(10.0 * ours.focal_length(pose), frame)
            camera.CreateFocusDistanceAttr().Set(pose.focus, frame)
            camera.CreateFStopAttr().Set(ours.f_number(pose), frame)
            camera.CreateClippingRangeAttr().Set(Gf.Vec2f(*pose.clipping), frame)

    def _write_solids(self, moment: Moment) -> None:
        """Write the meshes; what stands still has its transform here, what moves in the layers of frames."""
        geom, Vt, Gf = (self._pxr[name] for name in ("UsdGeom", "Vt", "Gf"))
        with self._stage(self.path(SOLIDS)) as stage:
            self._describe(stage)
            geom.Xform.Define(stage, WORLD)
            geom.Scope.Define(stage, f"{WORLD}/Solids")
            for i, surface in self.solids:
                mesh = geom.Mesh.Define(stage, solid_path(surface))
                mesh.CreatePointsAttr(vectors(Vt, surface.vertices))
                counts = np.full(len(surface.faces), 3, np.int32)
                mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
                corners = np.ascontiguousarray(surface.faces, np.int32).reshape(-1)
                mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
                mesh.CreateSubdivisionSchemeAttr("none")
                box = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
                mesh.CreateExtentAttr(vectors(Vt, box))
                if surface.color is not None:
                    mesh.CreateDisplayColorAttr([surface.color])
                operation = mesh.AddTransformOp()
                if self.job.solids[i].motion == "static":
                    operation.Set(Gf.Matrix4d(moment.poses[i].T.tolist()))

    def _describe(self, stage: Any) -> None:
        """Set what a stage must say of itself: axis, unit, time, the prim that it stands for."""
        geom = self._pxr["UsdGeom"]
        geom.SetStageUpAxis(stage, self.job.axes.up.upper())
        geom.SetStageMetersPerUnit(stage, 1.0 / self.job.axes.scale)
        stage.SetTimeCodesPerSecond(self.job.fps)
        stage.SetFramesPerSecond(self.job.fps)
        stage.SetMetadata("comment", self.job.title)
        stage.SetDefaultPrim(stage.OverridePrim(WORLD))

    @contextlib.contextmanager
    def _stage(self, path: Path) -> Iterator[Any]:
        """Yield a stage that is written to `path` when the block ends well. Errors: RunError."""
        with made_by_library(path) as place:
            try:
                stage = self._usd.Stage.CreateNew(str(place))
                yield stage
                stage.GetRootLayer().Save()
            except self._pxr["Tf"].ErrorException as error:
                said = str(error).strip().splitlines()[-1]
                raise RunError(f"{path} could not be written: {said}.") from error

    def _write_text(self, name: str, fill: Callable[[Any], None], below: Sequence[str] = ()) -> None:
        """Write a small stage, filled by `fill`, over the layers `below` as text. Errors: RunError."""
        layer = self._pxr["Sdf"].Layer.CreateAnonymous(".usda")
        fill(self._usd.Stage.Open(layer))
        layer.subLayerPaths = list(below)
        with replacing(self.path(name)) as file:
            file.write(layer.ExportToString().encode())


def vectors(Vt: Any, x: NDArray[Any]) -> Any:
    """Return vectors (n, 3) as an array of USD's."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(x, np.float32))


def solid_path(surface: SolidSurface) -> str:
    """Return where a solid is in the stage."""
    return f"{WORLD}/Solids/{surface.word}"
