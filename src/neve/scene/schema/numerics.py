"""Describe how the equations of a scene are solved: method, grid, transfer, integrator, step."""

from __future__ import annotations

from typing import Literal

from neve.registry import DEVICES, FIRST, METHODS
from neve.scene.values.choices import (
    DEFAULT_SPLINE,
    DEFAULT_TRANSFER,
    SPLINES,
    TRANSFERS,
    SplineWord,
    TransferWord,
    listed,
    meanings,
    sources,
    users,
)
from neve.scene.values.fields import (
    SHORTEST,
    Damping,
    Device,
    DeviceNumbers,
    Method,
    Modes,
    Part,
    Real,
    Step,
    Switch,
    Whole,
    entry,
)


class Numerics(Part):
    """Choose how the equations are solved."""

    method: Method = entry(METHODS.names()[0], f"How snow is simulated. {METHODS.meaning()}.", "")
    device: Device = entry(DEVICES.names()[0], f"Where the step is computed. {DEVICES.meaning()}.", "")
    devices: DeviceNumbers = entry(
        FIRST,
        "Numbers of the GPUs that share the run, as `neve info` lists them: each has a part of the snow.",
        "",
    )
    deterministic: Switch = entry(
        False,
        "Whether runs on GPUs repeat bit for bit, on one or several: all sums are made in a fixed order, "
        "which takes time. On the processor runs always repeat.",
        "",
    )
    dx: Real = entry(
        0.05, "Grid spacing; half of it means eight times as many particles.", "m", ge=SHORTEST, le=1000
    )
    spline: SplineWord = entry(
        DEFAULT_SPLINE,
        f"B-spline that weights the nodes around a particle. {meanings(SPLINES)}.",
        "",
        sources(SPLINES),
    )
    transfer: TransferWord = entry(
        DEFAULT_TRANSFER,
        f"How velocities are transferred between particles and grid. {meanings(TRANSFERS)}.",
        "",
        sources(TRANSFERS),
    )
    polypic_modes: Modes = entry(
        8,
        "Velocity modes per particle: 1 is its velocity alone, 4 are an affine velocity, 8 the multilinear "
        f"modes, 27 the modes up to degree 2 along each axis; used by {listed(users('polypic_modes'))}.",
        "1",
        "Fu et al. 2017 name the choices; 8: ours",
    )
    flip_alpha: Real = entry(
        0.95,
        f"Share of FLIP in the velocity update of one step; used by {listed(users('flip_alpha'))}.",
        "1",
        "Stomakhin et al. 2013 (as quoted in public codes)",
        ge=0,
        le=1,
    )
    flip_damping: Literal["off"] | Damping = entry(
        "off",
        "Decay rate of motion that the grid cannot resolve, in place of flip_alpha: alpha = "
        "exp(-flip_damping dt), so that the damping does not depend on the time step.",
        "1/s",
    )
    aflip_damping: Real = entry(
        0.5,
        "Decay rate of motion that the grid cannot resolve, times the time in which the fastest elastic wave "
        "of the snows before they harden crosses a cell: alpha = exp(-aflip_damping c dt / dx); used by "
        f"{listed(users('aflip_damping'))}.",
        "1",
        ge=0,
        le=1000,
    )
    integrator: Literal["explicit", "semi_implicit", "implicit"] = entry(
        "explicit",
        'How velocities follow from forces. "explicit": by the forces at the start of a step, which must be '
        'shorter than a wave takes through a cell; "semi_implicit": by those and their change in the step, '
        'a linear system; "implicit": by those at its end, plastic flow included. The last two take longer '
        "steps: see [implicit steps](implicit.md).",
        "",
        "semi_implicit: Stomakhin et al. 2013, section 4.1 (as quoted in public codes); explicit, implicit: "
        "textbooks",
    )
    implicit_beta: Real = entry(
        1.0,
        "Share of the change of the forces in a step that counts in it; less than 1 damps less, and stiff "
        'snow rings; used by integrator = "semi_implicit".',
        "1",
        "Stomakhin et al. 2013 name it (as quoted in public codes); the value is ours",
        ge=0.5,
        le=1,
    )
    implicit_rule: Literal["end", "midpoint"] = entry(
        "end",
        'Which velocities move and deform the snow in a step: "end", those at its end, of first order in dt; '
        '"midpoint", those in its middle, the implicit midpoint rule, of second order, which damps nothing '
        'and lets stiff snow ring; used by integrator = "semi_implicit" and "implicit".',
        "",
        "textbooks",
    )
    implicit_system: Literal["projected", "raw"] = entry(
        "projected",
        'Second derivatives of the energy in the system: "projected" without negative eigenvalues, which '
        'pressed snow has, by conjugate gradients; "raw" as they are, by conjugate residuals; used by '
        'integrator = "semi_implicit".',
        "",
        "raw: Stomakhin et al. 2013 (as quoted in public codes)",
    )
    implicit_tolerance: Real = entry(
        1e-3,
        "Forces that a solution may leave over on a piece of snow, as a share of gravity and stress.",
        "1",
        ge=1e-12,
        le=0.1,
    )
    implicit_iterations: Whole = entry(
        1000,
        "Iterations after which a system counts as not solved; its step is tried again with half of dt.",
        "1",
        ge=1,
        le=100000,
    )
    implicit_strain: Real = entry(
        0.01,
        "Largest change of deformation, dt |grad v|, in one automatic step that is not explicit; takes the "
        "place of strain_max there.",
        "1",
        ge=1e-4,
        le=1,
    )
    implicit_plasticity: Literal["return_map", "learned"] = entry(
        "return_map",
        'Where the forces of snow that flows come from while a step is solved: "return_map" of the law; '
        '"learned" of local energies that networks have learned from it, see [implicit steps](implicit.md); '
        'used by integrator = "implicit".',
        "",
        "learned: after Li et al. 2022 (from memory)",
    )
    dt: Literal["auto"] | Step = entry(
        "auto", 'Time step, or "auto" for the largest good one; shortened where it would be unstable.', "s"
    )
    cfl: Real = entry(
        0.4,
        "Fraction of a cell that a wave or a particle may cross in one automatic step; above 0.6 snow can "
        "gain energy.",
        "1",
        ge=1e-3,
        le=0.6,
    )
    strain_max: Real = entry(
        0.25,
        "Largest change of deformation, dt |grad v|, in one automatic step.",
        "1",
        ge=1e-3,
        le=1,
    )
    dt_max: Real = entry(1e-2, "Largest automatic time step.", "s", ge=SHORTEST, le=1)
    precision: Literal["float32", "float64"] = entry(
        "float32", "Floating-point format of particles and grid.", ""
    )
    particles_per_cell: Whole = entry(
        8,
        "Number of particles in a cell full of snow.",
        "1",
        "8 is two along each axis; our choice",
        ge=1,
        le=512,
    )
    sampling: Literal["jittered", "poisson", "regular"] = entry(
        "jittered",
        'How particles are placed: "jittered" moves each point of a lattice at random; "poisson" places '
        'them at random with a least distance between any two; "regular" leaves the lattice as it is, for '
        "comparison with exact solutions.",
        "",
        "poisson: Bridson 2007 names the goal; the algorithm is ours",
    )
    seed: Whole = entry(0, "Seed of all random numbers.", "1", ge=0, lt=2**32)
    initial_volume: Literal["sampled", "grid"] = entry(
        "sampled",
        'Volume of a particle: "sampled" divides the volume of the shape among its particles; "grid" '
        "measures the density on the grid in the first step, which comes out too low at the surface; steps "
        "are then a quarter to a third shorter.",
        "",
        "grid: Stomakhin et al. 2013, step 2 (as quoted in public codes); sampled: our choice, measured",
    )

    sleep: Switch = entry(
        False,
        "Whether snow at rest is left out of the step, block by block, until something moves it: cost then "
        "follows the snow that moves.",
        "",
    )
    sleep_speed: Real = entry(
        0.01,
        "Snow rests if its mean velocity over the time sleep_after is smaller; a neighbour that gets away "
        "twice as fast wakes it.",
        "m/s",
        gt=0,
        le=10,
    )
    sleep_after: Real = entry(0.2, "Time at rest after which snow sleeps.", "s", gt=0, le=10)

    @property
    def is_implicit(self) -> bool:
        """Return whether velocities follow from equations, not from the forces at the start of a step."""
        return self.integrator != "explicit"

    @property
    def spacing(self) -> float:
        """Return the mean distance of particles in snow at rest [m]."""
        return float(self.dx / self.particles_per_cell ** (1.0 / 3.0))
