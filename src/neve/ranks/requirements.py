"""What no run does over several ranks yet, each in one sentence."""

from __future__ import annotations

from neve.scene.errors import SceneError
from neve.scene.schema.scene import Scene


def require_able(scene: Scene, ranks: int) -> None:
    """Refuse a scene that ranks cannot share. Errors: SceneError: which key, and what to do."""
    numerics = scene.numerics
    lacking = (
        (numerics.method != "mpm", f'numerics.method = "{numerics.method}"', 'use "mpm"'),
        (numerics.device == "cuda", 'numerics.device = "cuda"', 'use "cpu"'),
        (numerics.is_implicit, f'numerics.integrator = "{numerics.integrator}"', 'use "explicit"'),
        (numerics.sleep, "numerics.sleep = true", "set it to false"),
        (scene.heat is not None, "heat", "leave [heat] out"),
        (bool(scene.emitters), "emitters", "leave them out"),
        (bool(scene.sinks), "sinks", "leave them out"),
    )
    for asked, what, otherwise in lacking:
        if asked:
            raise SceneError(
                f"{what}: a run over {ranks} ranks cannot do that; {otherwise}, or run it without mpirun"
            )
