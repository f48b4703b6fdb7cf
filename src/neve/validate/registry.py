"""The cases of the validation, in the order of the report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from neve.validate.elastic import bar, discs, refinement, settlement
from neve.validate.grains import collapse, contacts, cut, repose, slide, slip
from neve.validate.result import Result
from neve.validate.rigid import crater, wheel
from neve.validate.snow import cam_clay, oedometer, real_snow, time_step


@dataclass(frozen=True)
class Case:
    """Name a case: its title, the number of its known answer, and the function that runs it."""

    name: str
    title: str
    number: str
    run: Callable[[], Result]


CASES = {
    case.name: case
    for case in (
        Case("oedometer", "Compression in a rigid ring", "13", oedometer.case),
        Case("bar", "Vibration of a bar", "16", bar.case),
        Case("refinement", "Convergence", "27", refinement.case),
        Case("settlement", "A column settles", "15", settlement.case),
        Case("slide", "A block slides", "19, 21", slide.case),
        Case("slip", "A block on a surface that holds it", "19", slip.case),
        Case("discs", "Two elastic discs collide", "18", discs.case),
        Case("collapse", "A column of grains collapses", "22", collapse.case),
        Case("repose", "Slope of a heap", "23", repose.case),
        Case("contacts", "Particles in contact slide and heap", "19, 23", contacts.case),
        Case("cut", "A vertical cut", "24", cut.case),
        Case("cam_clay", "Yield and crushing of cohesive snow", "25", cam_clay.case),
        Case("time_step", "Refining the time step", "own", time_step.case),
        Case("crater", "A ball falls on snow", "own", crater.case),
        Case("wheel", "A wheel drives over snow", "own", wheel.case),
        Case("real_snow", "Against real snow", "own", real_snow.case),
    )
}
