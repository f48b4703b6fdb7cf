"""Figures over time: the live ones are those of the log, and a run's tables are read as they are."""

import shutil

import numpy as np
import pytest
from viewer.conftest import SMALL, converse

from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.run import run_scene
from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.viewer.players.figures import Figures, Sampler, of_run, unit_of
from neve.viewer.show import prepare

FRAMES = 5


@pytest.fixture(scope="module")
def counted(tmp_path_factory):
    """The folder of a run of the small scene with fragments."""
    folder = tmp_path_factory.mktemp("counted") / "run"
    scene = scene_from(SMALL | {"run": {"duration": 0.2, "film": False, "fragments": True}})
    run_scene(scene, folder, threads=1, frames=FRAMES, quiet=True)
    return folder


def by_name(message):
    """The values of each column of a message, in the order of the rows."""
    names = [column["name"] for column in message["columns"]]
    return {name: [row[k + 1] for row in message["rows"]] for k, name in enumerate(names)}


def test_live_figures_are_those_of_the_log(counted):
    """The same steps have the same sums; a force is a difference of impulses over a time."""
    sim, sampler, figures = Simulation(scene_from(SMALL), threads=1), Sampler(), Figures()
    figures.add(0, sampler.values(sim, True))
    for frame in range(1, FRAMES + 1):
        sim.advance(1 / sim.scene.run.fps)
        figures.add(frame, sampler.values(sim, True))
    live, run = by_name(figures.message(0)), by_name(of_run(RunFolder(counted)).message(0))
    exact = ("kinetic", "elastic", "potential", "mass", "momentum_z", "fragments", "dt_min")
    for name in exact:
        assert live[name] == run[name], name
    for name in ("colliders.0 force_z", "colliders.0 torque_x", "colliders.0 force", "colliders.1 force"):
        assert live[name][0] is None
        # Differences of sums of some 1e2 N s, in doubles, over 1/30 s.
        assert np.allclose(live[name][1:], run[name][1:], rtol=0, atol=1e-10), name
    total = np.array(run["colliders.0 force_z"][1:])
    assert np.abs(total).max() > 1.0
    assert np.allclose(
        np.array(run["colliders.0 force"][1:]) ** 2,
        sum(np.array(run[f"colliders.0 force_{axis}"][1:]) ** 2 for axis in "xyz"),
    )


def test_a_table_that_was_cut_short_ends_where_it_is(counted, tmp_path):
    """Whole rows before the cut are there, nothing is made up; a folder without a card is refused."""
    folder = shutil.copytree(counted, tmp_path / "cut")
    text = (folder / "log.csv").read_text()
    (folder / "log.csv").write_text(text[: text.rindex(",")])
    kinetic = by_name(of_run(RunFolder(folder)).message(0))["kinetic"]
    assert kinetic[:-1] == by_name(of_run(RunFolder(counted)).message(0))["kinetic"][:-1]
    assert kinetic[-1] is None  # the frame is there by its solids
    (folder / "run.json").unlink()
    with pytest.raises(RunError, match=r"run\.json"):
        of_run(RunFolder(folder))


def test_units_follow_from_names():
    """Energies are in joules, forces in newtons, whatever they are of; a count has no unit."""
    names = [
        "kinetic",
        "bodies_kinetic",
        "momentum_x",
        "bodies.1 force_y",
        "robots.0.arm torque_z",
        "dt_mean",
    ]
    assert [unit_of(name) for name in names] == ["J", "J", "kg m/s", "N", "N m", "s"]
    assert unit_of("seconds_p2g") == "s"
    assert unit_of("fragments mass of powder") == "kg"
    assert unit_of("particles") == unit_of("fragments") == ""


def test_rows_follow_the_frames(small, tmp_path):
    """Who asks gets all rows, then each new one; a new beginning begins them again."""

    async def talk(page, port):
        await page.send(do="plot")
        first = await page.until(lambda p: p.message("figures"))
        assert first["first"] == 0
        assert len(first["rows"]) == 1
        for frame in (1, 2):
            await page.send(do="frame")
            await page.until(lambda p, frame=frame: p.message("figures")["rows"][-1][0] == frame)
        last = page.message("figures")
        assert (last["first"], len(last["rows"])) == (2, 1)
        await page.send(do="restart")
        await page.until(lambda p: p.message("figures")["rows"][-1][0] == 0)
        assert page.message("figures")["first"] == 0

    converse(prepare(str(small), out=str(tmp_path / "out"), threads=1), talk)


def test_a_run_is_looked_up_by_time(recorded):
    """A moment of a plot shows the frame next to it."""

    async def talk(page, port):
        await page.send(do="plot")
        rows = (await page.until(lambda p: p.message("figures")))["rows"]
        assert [row[0] for row in rows] == list(range(FRAMES + 1))
        await page.send(do="seek", time=0.11)
        await page.until(lambda p: p.head["frame"] == 3)  # at 30 frames a second

    converse(prepare(str(recorded)), talk)
