"""Growth of energy that nothing accounts for: a value in each row of the log, one warning."""

import logging
from types import SimpleNamespace

import numpy as np
import pytest

from neve.diagnostics import Balance
from neve.run import run_scene
from neve.run.outputs.log import EnergyWatch
from neve.run.progress import Silence, warnings_to
from neve.scene.reading.load import scene_from

ADVICE = "lower numerics.cfl"


def moment(kinetic=100.0, affine=0.0, elastic=10.0, potential=50.0, work=0.0):
    return SimpleNamespace(kinetic=kinetic, affine=affine, elastic=elastic, potential=potential, work=work)


def test_excess_is_what_nothing_accounts_for(caplog):
    """Falling, work of a collider and dissipation are no excess; the rest is, to the joule."""
    watch = EnergyWatch(None, ADVICE)
    with caplog.at_level("WARNING", logger="neve"):
        assert watch.excess(moment(), 0) is None
        assert watch.excess(moment(kinetic=130.0, potential=20.0), 1) == 0.0
        assert watch.excess(moment(kinetic=150.0, potential=20.0, work=20.0), 2) == 0.0
        assert watch.excess(moment(kinetic=140.0, potential=20.0, work=20.0), 3) == -10.0
        assert watch.excess(moment(kinetic=141.0, potential=20.0, work=20.0), 4) == 1.0
    assert not caplog.records  # 1 J of 151 J is below 1 %


def test_growth_is_told_once(caplog):
    """5 J more of 115 J that move: one warning with frame, amount and remedy; then the log alone."""
    watch = EnergyWatch(None, ADVICE)
    with caplog.at_level("WARNING", logger="neve"):
        watch.excess(moment(), 6)
        assert watch.excess(moment(elastic=15.0), 7) == 5.0
        assert watch.excess(moment(elastic=25.0), 8) == 10.0
    (record,) = caplog.records
    for part in ("frame 7", "5 J", ADVICE):
        assert part in record.getMessage()


def test_a_resumed_run_goes_on_with_the_last_row():
    """The watch starts from the log's own numbers, so that the log of a resumed run is the same."""
    row = {name: repr(value) for name, value in vars(moment(kinetic=90.0)).items()}
    assert EnergyWatch(row, ADVICE).excess(moment(kinetic=92.5), 9) == 2.5
    assert Balance.of_row(row).total == 150.0


def test_a_row_without_a_number_says_nothing():
    """A cell that is empty, as that of NaN is, or lost: nothing is known of the growth, and nothing told."""
    row = {name: repr(value) for name, value in vars(moment(kinetic=90.0)).items()} | {"work": ""}
    watch = EnergyWatch(row, ADVICE)
    assert np.isnan(watch.excess(moment(kinetic=500.0), 9))
    assert watch.excess(moment(kinetic=500.0), 10) == 0.0


def test_sentences_go_to_the_progress():
    """Inside the block the progress says what is logged under "neve"; afterwards logging is as it was."""
    said = []
    progress = Silence()
    progress.say = said.append
    logger = logging.getLogger("neve.some.module")
    with warnings_to(progress):
        logger.warning("snow is %s", "warm")
    assert said == ["warning: snow is warm"]
    assert logging.getLogger("neve").propagate
    assert not logging.getLogger("neve").handlers
    with pytest.raises(OSError, match="disk"), warnings_to(progress):
        raise OSError("disk")
    assert not logging.getLogger("neve").handlers


@pytest.mark.parametrize(
    ("method", "advice"), [("mpm", "lower numerics.cfl or"), ("sph", "where pressed snow yields sideways")]
)
def test_each_method_has_its_advice(method, advice, tmp_path, monkeypatch):
    """The run hands the watch what its method says of such growth."""
    handed = []
    monkeypatch.setattr("neve.run.outputs.log.EnergyWatch", lambda last, advice: handed.append(advice))
    described = {
        "numerics": {"method": method, "dx": 0.1},
        "sources": [{"shape": "sphere", "radius": 0.15}],
        "run": {"duration": 0.02, "fps": 50, "film": False},
    }
    run_scene(scene_from(described), tmp_path / "run", quiet=True)
    (given,) = handed
    assert advice in given
