"""`neve bench --compare`: the speeds of a file beside those of now."""

import csv
import dataclasses
import functools
import io
import json
import time
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE
from scripts import script

from neve.bench import run as bench
from neve.bench.choices import measure_choices, scenes
from neve.bench.compare import compared, read_earlier
from neve.bench.competitor import Competitor, measure_competitor
from neve.bench.heat import measure_heat
from neve.bench.loose import DX, block, measure_loose, scatter
from neve.bench.snowfall import measure_still
from neve.bench.spread import Spread
from neve.bench.walk import FPS, measure_walk
from neve.io.errors import RunError
from neve.render.path_tracing.picture import Choices
from neve.scene.reading.load import load
from neve.scene.values.choices import DEFAULT_LAW, DEFAULT_SPLINE, DEFAULT_TRANSFER, LAWS, SPLINES, TRANSFERS
from neve.simulation import Simulation

RESULTS = Path(__file__).parents[3] / "benchmarks/results"


@pytest.fixture
def speed():
    """One small measurement: a block of 64 particles."""
    return bench.measure("tiny", bench.Block((2, 2, 2), steps=2, batches=2, warm=1))


def faster(speed, factor):
    """Return `speed` as if each stage had taken a factor less time."""
    scaled = {stage: Spread.of([spread.median / factor]) for stage, spread in speed.stage_ms.items()}
    return dataclasses.replace(speed, stage_ms=scaled, step_ms=Spread.of([speed.step_ms.median / factor]))


def ratios(speed, earlier):
    """Return what was printed as a dict of stages."""
    (line,) = compared(speed, earlier)
    return {part.split()[0]: float(part.split()[1]) for part in line.split(": ")[1].split(", ")}


def written(speed, path, form):
    """Write `speed` as the tools do: JSON of the command, or a row of the CSV."""
    found = {
        "machine": {"cpu": "a processor", "isa": "x86-64-v3", "compiler": "gcc"},
        "results": [dataclasses.asdict(speed)],
    }
    if form == "json":
        path.write_text(json.dumps(found))
        return path
    with script("benchmarks", "to_csv") as to_csv:
        out = io.StringIO()
        rows = csv.DictWriter(out, to_csv.COLUMNS, lineterminator="\n")
        rows.writeheader()
        rows.writerow({"date": "2026-01-01", **to_csv.row(found["machine"], found["results"][0])})
    path.write_text(out.getvalue())
    return path


@pytest.mark.parametrize("form", ["json", "csv"])
def test_ratios(speed, tmp_path, form):
    """Twice as fast is a ratio of 0.5 in each stage that took time; the file's machine is told."""
    before = read_earlier(written(speed, tmp_path / "before", form))
    found = ratios(faster(speed, 2), before)
    assert {"p2g", "grid", "g2p", "step"} <= set(found)
    assert set(found.values()) == {0.5}
    assert "a processor, x86-64-v3, gcc" in compared(speed, before)[0]


def test_only_the_same_case_is_compared(speed, tmp_path):
    """The latest one of the same case counts; another number of threads is another case."""
    path = written(speed, tmp_path / "before.json", "json")
    found = json.loads(path.read_text())
    slower = json.loads(json.dumps(found["results"][0]))
    slower["step_ms"]["median"] *= 4
    found["results"].append(slower)
    path.write_text(json.dumps(found))
    assert ratios(speed, read_earlier(path))["step"] == 0.25
    other = dataclasses.replace(speed, threads=speed.threads + 1)
    assert compared(other, read_earlier(path)) == ["  nothing to compare with: the file has no such case"]


@pytest.mark.parametrize("path", sorted(RESULTS.glob("*.csv")), ids=lambda path: path.name)
def test_files_of_results_can_be_compared_with(path):
    """Each has speeds of a step."""
    assert read_earlier(path)


@pytest.mark.parametrize(
    "text",
    ["", "{}", "[1]", "a,b\n1,2\n", '{"machine": {}, "results": [{"stage_ms": 1}]}', "step_ms\nfast\n", "\0"],
)
def test_what_holds_no_speeds(tmp_path, text):
    """One sentence that names the file."""
    path = tmp_path / "before"
    path.write_text(text)
    with pytest.raises(RunError, match=r"before holds no speed"):
        read_earlier(path)
    with pytest.raises(RunError, match="missing"):
        read_earlier(tmp_path / "missing")


def test_loose_snow_is_the_block_scattered():
    """The same particles in a cube with the wanted number a cell, in many more blocks of the grid."""
    dense, loose = Simulation(block()), Simulation(block())
    scatter(loose, 0.5)
    size = np.ptp(np.asarray(loose.state.x), axis=0) / DX
    assert loose.count == dense.count == 20_000
    assert loose.count / size.prod() == pytest.approx(0.5, rel=0.01)
    for sim in (dense, loose):
        sim.advance(1e-4)
    assert loose.diagnostics().blocks > 5 * dense.diagnostics().blocks


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs the times of another process")
def test_a_competitor_computes_when_it_is_told_to():
    """It takes processor time while it is busy, none while it rests, and is gone at the end."""

    def ticks():
        return int(Path(f"/proc/{competitor.pid}/stat").read_text().rpartition(")")[2].split()[11])

    def wait_for(enough):
        until = time.monotonic() + PATIENCE
        while not enough() and time.monotonic() < until:
            time.sleep(0.01)
        assert enough()

    def rests():
        return Path(f"/proc/{competitor.pid}/stat").read_text().rpartition(")")[2].split()[0] == "T"

    with Competitor() as competitor:
        wait_for(rests)
        begun = ticks()
        competitor.compute(True)
        wait_for(lambda: ticks() >= begun + 10)
        competitor.compute(False)
        wait_for(rests)
        stopped = ticks()
        time.sleep(0.2)
        assert ticks() == stopped
    assert not Path(f"/proc/{competitor.pid}").exists()


def test_speed_beside_a_competitor():
    """Both kinds of batches take steps, and what is kept is their ratio."""
    sim = Simulation(bench.landing_block((2, 2, 2)))
    found = measure_competitor(sim, bench.DT, steps=2, batches=1, seconds=0.01)
    assert sim.steps >= 4
    assert found.kept.median == pytest.approx(found.beside.median / found.alone.median)
    assert "64 particles" in found.text()
    assert f"{found.threads / (found.threads + 1):.0%}" in found.text()


def test_loose_snow_is_measured_beside_dense_snow():
    """Each stage that took time, in pairs of batches; the text names both and their ratio."""
    found = measure_loose(per_cell=1.0, batches=2, steps=1)
    assert (found.particles, found.batches, found.per_cell) == (20_000, 2, 1.0)
    assert found.ratio.least > 0
    assert {"p2g", "grid", "g2p"} <= set(found.growth_ns)
    assert "1 a cell" in found.text()
    assert f"ratio {found.ratio.median:.2f}" in found.text()


def test_each_choice_is_measured():
    """Every transfer, spline, law and precision once, beside the defaults; the text names them all."""
    small = functools.partial(bench.landing_block, (3, 3, 3))
    found = measure_choices(small, bench.DT, batches=2, steps=2, warm=1)
    names = [*TRANSFERS, *SPLINES, *LAWS]
    usual = {DEFAULT_TRANSFER, DEFAULT_SPLINE, DEFAULT_LAW}
    assert {"defaults", "float64", "polypic, 27 modes", *names} - usual == set(found.ns)
    assert next(iter(found.ns)) == "defaults"
    assert min(spread.least for spread in found.ns.values()) > 0
    assert all(name in found.text() for name in found.ns)
    made = scenes(small)
    assert made["float64"].numerics.precision == "float64"
    assert all(made[name].numerics.transfer == name for name in list(TRANSFERS)[1:])
    assert all(made[name].numerics.spline == name for name in list(SPLINES)[1:])
    assert all(made[name].snow.law == name for name in list(LAWS)[1:])


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
def test_walk_counts_pictures():
    """The steps of a picture, its times and the share of sleepers are those of the scene that is measured."""
    scene = load("walk_live", ["numerics.dx=0.15", "numerics.sleep_after=0.02"])
    found = measure_walk(lambda: 33.0, scene, settled=0.2, pictures=3)
    assert found.pictures == 3
    assert found.steps * scene.numerics.dt_max >= 1 / FPS
    assert 0.0 < found.asleep < 1.0
    assert 0.0 < found.wall_ms.least <= found.wall_ms.median <= found.wall_ms.largest
    awake = found.particles * (1.0 - found.asleep) * found.steps
    assert found.step_ns.median == pytest.approx(1e6 * found.cpu_ms.median / awake, rel=0.9)
    assert f"{found.particles:,} particles" in found.text()
    assert "material points 33 ns" in found.text()
    whole = sum(found.stage_ms.values())
    assert 0.999 * found.wall_ms.least <= whole <= 1.001 * found.wall_ms.largest
    assert found.stage_ms["step"] > 0.0
    assert all(stage in found.text() for stage in found.stage_ms)


def test_heat_is_measured_by_each_method():
    """A pass has rounds, lies some steps of the method after the last, and takes its share of the time."""
    found = {cost.method: cost for cost in measure_heat(steps=2, batches=2)}
    assert set(found) == {"mpm", "particles"}
    for cost in found.values():
        assert cost.particles == 20_000
        assert cost.rounds >= 1
        assert cost.steps > 1
        a_pass, a_step = cost.pass_ns.median, cost.step_ns.median
        assert cost.share == pytest.approx(a_pass / (a_pass + cost.steps * a_step))
        assert f"{cost.rounds} rounds" in cost.text()


def test_a_snowed_still_is_drawn_and_timed():
    """Each cell of a height map has one place; the picture comes after the snow; threads add up."""
    pytest.importorskip("mitsuba")
    found = measure_still(16, 20, Choices("draft", samples=1, size=(64, 36), denoise=False))
    assert (found.triangles, found.places) == (2 * 19 * 19, 256)
    assert 0.0 < found.snow_s < found.wall_s
    assert found.process_s > 0.0
    assert "its picture is there after" in found.text()
