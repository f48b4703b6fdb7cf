"""Live, by every method, and with heat: over the real socket, no browser."""

import pytest
from viewer.conftest import SMALL, converse
from viewer.test_live import places, told

from neve.registry import METHODS
from neve.scene.reading.load import scene_from, to_toml
from neve.viewer.show import prepare


@pytest.mark.parametrize("method", METHODS.names())
def test_each_method_is_played_with(method, tmp_path):
    """By every method: constants are set while it runs, a ball is thrown, and snow goes with the pointer."""
    path = tmp_path / "small.toml"
    numerics = {"method": method, "dx": 0.1}
    still = {"numerics": numerics, "world": {"gravity": [0.0, 0.0, 0.0]}}
    path.write_text(to_toml(scene_from(SMALL | still)), encoding="utf-8")
    server = prepare(str(path), out=str(tmp_path / "out"), threads=1)

    async def talk(page, port):
        await page.send(do="set", path="snow.E0", value=2e4)
        await page.send(do="set", path="snow.theta_s", value=0.02)
        await page.until(lambda p: (told(p, "snow.E0"), told(p, "snow.theta_s")) == (2e4, 0.02))
        await page.send(do="frame")
        await page.until(lambda p: p.head["frame"] == 1)
        running = server.player.running().snow
        assert (running.E0, running.theta_s) == (2e4, 0.02)
        before = page.head["n"]
        await page.send(do="throw", origin=[0, 0, 2], direction=[0, 0, -2], speed=1.0, radius=0.2)
        await page.until(lambda p: p.head["n"] > before)
        assert places(page)[before:, 2].mean() == pytest.approx(1.6, abs=0.05)
        await page.send(do="play")
        for _ in range(400):
            await page.send(do="touch", tool="grab", point=[0, 0, 0.5], velocity=[2.0, 0, 0], radius=0.5)
            count = len(page.states)
            await page.until(lambda p, count=count: len(p.states) > count)
            if places(page)[:before, 0].mean() > 0.02:
                return
        raise AssertionError("the snow did not follow the pointer")

    converse(server, talk)


def test_a_page_is_told_that_heat_runs_faster(tmp_path):
    """The message of a scene has what films say of it, also once heat is as fast as motion: then nothing."""
    path = tmp_path / "warm.toml"
    path.write_text(to_toml(scene_from(SMALL | {"heat": {"heat_speed": 50.0}})), encoding="utf-8")

    async def talk(page, port):
        assert page.message("scene")["caption"] == "heat x 50 real time"
        await page.send(do="set", path="heat.heat_speed", value=1.0)
        await page.until(lambda p: p.message("scene")["caption"] == "")

    converse(prepare(str(path), out=str(tmp_path / "out"), threads=1), talk)
