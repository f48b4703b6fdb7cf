"""A box of known place and volume, and what every mesh file of it must give."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from meshes import CORNERS

from neve.geometry.mesh import read_mesh
from neve.geometry.triangles import Triangles
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Collider

Holding = Callable[..., Triangles]


@pytest.fixture
def surface(tmp_path: Path) -> Holding:
    """Return a function that writes `content` as `name` and reads it as a collider does."""

    def read(name: str, content: bytes | str) -> Triangles:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_mesh(Collider.of("mesh", file=str(path)), "colliders.0")

    return read


@pytest.fixture
def is_box(surface: Holding) -> Holding:
    """Return a function that reads a file and demands the box: closed, 1 m3, at its place, outside out."""

    def check(name: str, content: bytes | str, within: float = 1e-7) -> Triangles:
        found = surface(name, content)
        assert found.open_edges == 0
        assert found.volume == pytest.approx(1.0, rel=2 * within)
        assert found.low == pytest.approx(CORNERS.min(axis=0), rel=within)
        assert found.high == pytest.approx(CORNERS.max(axis=0), rel=within)
        return found

    return check


@pytest.fixture
def refused(surface: Holding) -> Callable[[str, bytes | str], str]:
    """Return a function that reads a file and returns the one sentence by which it is refused."""

    def sentence(name: str, content: bytes | str) -> str:
        with pytest.raises(SceneError) as caught:
            surface(name, content)
        text = str(caught.value)
        assert text.startswith("colliders.0.file = ")
        assert "\n" not in text
        assert "damaged, or not the kind" not in text
        return text

    return sentence
