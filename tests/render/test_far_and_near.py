"""Pictures of what lies too far, too near or nowhere: the rest of the picture is as if it were not there.

Run under the sanitizers (CONTRIBUTING.md), these see every number that does not fit into an integer.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from neve.colliders.solid import Solid
from neve.geometry.pose import Pose
from neve.render.preview import Preview
from neve.scene.schema.scene import Camera, Light, Numerics, Scene, Source

CAMERA = Camera(position=(0.0, -6.0, 1.5), target=(0.0, 0.0, 0.5), fov=35)
SNOW = np.stack(np.meshgrid(*3 * [np.linspace(-0.2, 0.2, 8)]), axis=-1).reshape(-1, 3).astype(np.float32)
STILL = np.zeros(3)


def draw(x, solids=(), camera=CAMERA):
    stage = Scene(
        sources=(Source.of("sphere"),),
        camera=camera,
        light=Light(sun_azimuth=200, sun_elevation=35),
        numerics=Numerics(dx=0.1),
    )
    posed = [(solid, Pose(STILL, np.eye(3), STILL, STILL)) for solid in solids]
    return Preview(stage, 96, 54, threads=1).draw(x.astype(np.float32), posed)


@pytest.mark.parametrize("far", [np.nan, np.inf, -1e30, 3e9, 1e12])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_particles_out_of_sight(far, axis):
    """A particle that is nowhere or behind all horizons changes no pixel."""
    lost = np.zeros((1, 3))
    lost[0, axis] = far
    here = draw(SNOW)
    behind = not np.isfinite(far) or far < 0 or axis != 1
    there = draw(np.concatenate([SNOW, lost]))
    assert there.shape == here.shape
    if behind:
        np.testing.assert_array_equal(there, here)


@pytest.mark.parametrize("distance", [0.0, 1e-6, 1e-3, 0.05, 0.3])
def test_particles_at_the_eye(distance):
    """A particle in front of the lens fills at most the picture; no number runs over."""
    eye = np.array([[0.0, -6.0 + distance, 1.5]])
    assert draw(np.concatenate([SNOW, eye])).any()


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6])
def test_meshes_through_the_eye(size):
    """A sheet that begins at the lens and ends at the horizon: rows of it reach far beyond the picture."""
    corners = np.array([[-size, -6.0, 1.4], [size, -6.0, 1.4], [size, size, 1.4], [-size, size, 1.4]])
    sheet = SimpleNamespace(vertices=corners, faces=np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    picture = draw(SNOW, [Solid(name="sheet", shape="mesh", mesh=sheet)])
    assert picture.std() > 0


@pytest.mark.parametrize("height", [1.0, 1e3, 9e5])
def test_the_ground_from_any_height(height):
    """The ground's noise goes on however far away it is."""
    camera = Camera(position=(0.0, -6.0, height), target=(0.0, 0.0, 0.0), fov=35)
    ground = Solid(name="ground", shape="plane")
    assert draw(SNOW, [ground], camera).any()
