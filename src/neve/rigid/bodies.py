"""Rigid bodies that snow pushes: MuJoCo moves them, their joints and their contacts with one another."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.motion import path_of, pose
from neve.colliders.solid import Solid, solid_of
from neve.geometry.pose import Pose, cross
from neve.reproducible import product
from neve.rigid.assembly import TIME_CONSTANT, Assembly, assemble
from neve.rigid.coupled_bodies import LostBody
from neve.rigid.dynamics import constraints_of, dynamics_of
from neve.rigid.engine import engine, forget
from neve.rigid.hand import Hand
from neve.rigid.products import times
from neve.rigid.robot_solids import robot_solids
from neve.rigid.soundness import require_apart, require_few, require_movable
from neve.scene.schema.scene import Scene

Array = NDArray[np.float64]

MAX_STEP = 5e-4
"""Longest step of the engine [s]."""
FIRST_STEP = 1e-4
"""Length of the engine's step that is assumed before the first one [s]."""
MOST_STEPS = 1000
"""Steps of the engine in one of the snow, at most."""
SUNK = 0.5
"""Way that a body may sink in, over the smallest half extent of all bodies [1]."""
LEFT = 0.1
"""Share of that way which a contact has at least, however deep a body is [1]."""
LARGEST = 1e10
"""Positions and velocities beyond this count as lost, as they do for the engine [m, m/s, rad/s]."""


class RigidBodies:
    """Hold the bodies of a scene in the rigid-body engine.

    A solid's frame is that of its shape in the scene, such as the centre of a box or the origin of a mesh
    file; not the centre of mass. Its velocity is that of the frame's origin. All vectors are in
    world axes.
    """

    def __init__(self, scene: Scene, colliders: Sequence[Solid]) -> None:
        """Assemble the bodies of `scene`, which also touch `colliders`, the solids of `scene.colliders`.

        Errors: SceneError for a robot that cannot be read, and for bodies inside one another.
        """
        self._mj = engine()
        forget()
        bodies = tuple(
            solid_of(body, f"bodies.{i}", scene.numerics.dx) for i, body in enumerate(scene.bodies)
        )
        self._assembly: Assembly = assemble(scene, colliders, bodies)
        self._model = self._assembly.model
        of_files = sum(len(loaded.geoms) for loaded in self._assembly.robots)
        require_few(self._model, len(bodies) + of_files)
        of_robots = [
            found
            for loaded in self._assembly.robots
            for found in robot_solids(self._model, loaded, scene.numerics.dx)
        ]
        self._assembly.attachments += [attachment for _, attachment in of_robots]
        self.solids = (*bodies, *(solid for solid, _ in of_robots))
        """The solids that the engine moves: all bodies, then those of all robots."""
        self._data = self._mj.MjData(self._model)
        # Robots have the contacts of their files.
        self._rows = np.array([held.body for held in self._assembly.attachments[: len(bodies)]], dtype=int)
        self._half = min((_half(solid) for solid in bodies), default=math.inf)
        self._own_contacts = np.flatnonzero(self._model.geom_solref[:, 0] == TIME_CONSTANT)
        self._contact_time = TIME_CONSTANT
        self._signature = int(self._mj.mjtState.mjSTATE_INTEGRATION)
        self._paths = [
            (path_of(collider), self._data.mocap_pos[mocap], self._data.mocap_quat[mocap])
            for collider, mocap, _ in self._assembly.scripted
        ]
        self._model.opt.timestep = FIRST_STEP
        self._data.qpos[:] = self._assembly.start
        self._data.qvel[:] = self._assembly.speeds
        self._dynamics = dynamics_of(self._mj, self._model, self._data, self._assembly.attachments)
        self.motion = self._dynamics.motion
        """Where the solids are and how they move in the next step."""
        self.hand = Hand()
        """What somebody does to the bodies beside the scene: nothing at first."""
        self._refresh()
        require_movable(self._model, self._data)
        require_apart(self._model, self._data)

    def poses(self) -> list[Pose]:
        """Return where the frame of each solid is and how it moves."""
        now = self.motion
        placed = zip(now.centres, now.rotations, now.rates, strict=True)
        return [Pose(x, R, rate[:3], rate[3:]) for x, R, rate in placed]

    def advance(self, dt: float, exchanged: Array, time: float) -> None:
        """Move the bodies from `time` on by `dt` [s] under what they exchanged with the snow.

        exchanged: (n, 7), impulse of the snow on each solid [N s], its moment about the frame's origin
        [N m s], work [J] (not used). It acts as a constant force and torque. The engine takes equal steps of
        at most MAX_STEP, as much shorter as contacts are stiffer.

        Errors: LostBody if what was exchanged, or a position or a velocity afterwards, is not finite.
        """
        model, data = self._model, self._data
        if abs(time - data.time) > 1e-9 * max(1.0, time):
            data.time = time
            self._refresh()
        longest = MAX_STEP * self._contact_time / TIME_CONSTANT
        count = min(max(1, math.ceil(dt / longest - 1e-9)), MOST_STEPS)
        model.opt.timestep = dt / count
        if self.hand.springs:
            held = [attachment.body for attachment in self._assembly.attachments]
            trees = model.body_subtreemass[model.body_rootid[held]]
            exchanged = exchanged + self.hand.impulses(self.solids, self.poses(), self.mass, trees, dt)
        lost = self._dynamics.apply(exchanged, dt)
        if lost is not None:
            name = self.solids[lost].name
            raise LostBody(f"the snow pushes {name} without a finite force at t = {time:.6g} s")
        for i in range(count):
            if i:
                data.time = time + i * model.opt.timestep
                self._begin_step()
            self._set_controls(data.time)
            self._mj.mj_step2(model, data)
        data.xfrc_applied[:] = 0.0
        data.time = time + dt
        self._require_finite(time + dt)
        self._refresh()

    def set_gravity(self, gravity: Array) -> None:
        """Let the bodies fall with `gravity` (3,) [m/s2] from now on."""
        self._model.opt.gravity[:] = gravity

    def save(self) -> dict[str, Array]:
        """Return all that `restore` needs to go on with the same bits."""
        state = np.zeros(self._mj.mj_stateSize(self._model, self._signature))
        self._mj.mj_getState(self._model, self._data, state, self._signature)
        return {"engine": np.append(state, self._model.opt.timestep)}

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Put the bodies back to where `save` found them.

        Errors: ValueError if `arrays` come from other bodies.
        """
        state = np.array(arrays["engine"])
        if state.dtype != np.float64 or not np.isfinite(state).all():
            raise ValueError("the state of the bodies holds what is no finite number")
        if state.shape != (self._mj.mj_stateSize(self._model, self._signature) + 1,):
            raise ValueError(
                f"the state of the bodies has {state.size} numbers, which does not fit the scene"
            )
        if not 0 < state[-1] <= 1:
            raise ValueError(f"the bodies take steps of {state[-1]:g} s")
        self._mj.mj_setState(self._model, self._data, state[:-1], self._signature)
        self._model.opt.timestep = state[-1]
        self._refresh()

    def take_over(self, other: RigidBodies) -> None:
        """Put the bodies to where those of `other` are, the same ones, maybe among other colliders.

        The engine's state also holds the colliders that a script moves, so it fits where those are as many.
        """
        self.hand = other.hand
        state = other.save()
        if len(state["engine"]) == self._mj.mj_stateSize(self._model, self._signature) + 1:
            return self.restore(state)
        for name in ("qpos", "qvel", "act", "qacc_warmstart"):
            getattr(self._data, name)[:] = getattr(other._data, name)
        self._data.time = other._data.time
        self._model.opt.timestep = other._model.opt.timestep
        self._refresh()

    def controls(self) -> list[tuple[str, float, float, float]]:
        """Return name, least and greatest value, and the value now of each motor and actuator.

        The range is the engine's; without one, to twice the greatest value of the scene's, at least 1, on
        both sides of 0.
        """
        scripted = {control.actuator: np.abs(control.values).max() for control in self._assembly.controls}
        found = []
        for i in range(self._model.nu):
            low, high = self._model.actuator_ctrlrange[i]
            if not self._model.actuator_ctrllimited[i]:
                high = max(1.0, 2.0 * float(scripted.get(i, 0.0)))
                low = -high
            name = self._model.actuator(i).name
            found.append((name, float(low), float(high), float(self._data.ctrl[i])))
        return found

    @property
    def momentum(self) -> Array:
        """Sum of m v over the bodies [kg m/s], (3,)."""
        return self._sums()[0]

    @property
    def angular_momentum(self) -> Array:
        """Angular momentum of the bodies about the origin of the world [kg m2/s], (3,)."""
        return self._sums()[1]

    @property
    def kinetic(self) -> float:
        """Kinetic energy of the bodies [J]."""
        moved = np.zeros(self._model.nv)
        self._mj.mj_mulM(self._model, self._data, moved, self._data.qvel)
        return float(0.5 * np.sum(moved * self._data.qvel))

    @property
    def potential(self) -> float:
        """Energy of the bodies in the field of gravity, zero at the origin of the world [J]."""
        mass = self._model.body_mass
        return float(-np.sum(mass[:, None] * self._data.xipos * self._model.opt.gravity))

    @property
    def mass(self) -> Array:
        """Mass of the body that carries each solid [kg], (n,)."""
        return np.array([self._model.body_mass[held.body] for held in self._assembly.attachments])

    def _sums(self) -> tuple[Array, Array]:
        """Return momentum and angular momentum, from the velocities of the centres of mass."""
        model, data = self._model, self._data
        momentum, angular = np.zeros(3), np.zeros(3)
        linear, turning = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for body in range(1, model.nbody):
            self._mj.mj_jacBodyCom(model, data, linear, turning, body)
            p = model.body_mass[body] * times(linear, data.qvel)
            axes = data.ximat[body].reshape(3, 3)
            momentum += p
            spin = product(axes.T, times(turning, data.qvel))
            angular += np.cross(data.xipos[body], p) + product(axes, model.body_inertia[body] * spin)
        return momentum, angular

    def _begin_step(self) -> None:
        """Do the first half of a step of the engine: positions, velocities, contacts, and what these aim at.

        The engine takes mocap bodies to be at rest. What a contact aims at, -B u - K r with the velocity u
        of one surface past the other, is therefore corrected by the velocity of a moving collider's surface.
        """
        model, data = self._model, self._data
        for path, position, orientation in self._paths:
            path.place(data.time, position, orientation)
        self._mj.mj_step1(model, data)
        if not self._paths or not data.ncon:
            return
        motions = {geom: pose(collider, data.time) for collider, _, geom in self._assembly.scripted}
        held = np.asarray(data.contact.efc_address) >= 0
        moved = np.isin(data.contact.geom, list(motions)).any(axis=1)
        for i in np.flatnonzero(held & moved).tolist():
            contact = data.contact[i]
            surface = np.zeros(3)
            for geom, sign in zip(contact.geom, (-1.0, 1.0), strict=True):
                if at := motions.get(int(geom)):
                    surface += sign * (at.velocity + cross(at.omega, contact.pos - at.position))
            rows = slice(contact.efc_address, contact.efc_address + min(contact.dim, 3))
            along = product(contact.frame.reshape(3, 3)[: min(contact.dim, 3)], surface)
            data.efc_aref[rows] -= data.efc_KBIP[rows, 1] * along

    def _stiffen(self) -> bool:
        """Choose the time of contacts such that no body sinks in too far; return whether it changed.

        In TIME_CONSTANT a cannonball goes farther than the ground that it hits is thick. Where something
        touches and the fastest body would use up what is left of SUNK of the smallest half extent, contacts
        are as much faster.
        """
        data, rows, time = self._data, self._rows, TIME_CONSTANT
        if data.ncon and len(rows):
            offset = data.xipos[rows] - data.subtree_com[self._model.body_rootid[rows]]
            speed = np.abs(data.cvel[rows, 3:] + np.cross(data.cvel[rows, :3], offset)).max()
            for collider, _, _ in self._assembly.scripted:
                speed += np.abs(pose(collider, data.time).velocity).max()
            left = SUNK * self._half + min(0.0, float(np.min(data.contact.dist)))
            left = max(left, LEFT * SUNK * self._half)
            if speed * TIME_CONSTANT > left and np.isfinite(speed):
                time = left / speed
        if time == self._contact_time:
            return False
        self._contact_time = time
        self._model.geom_solref[self._own_contacts, 0] = time
        return True

    def _set_controls(self, time: float) -> None:
        for control in self._assembly.controls:
            self._data.ctrl[control.actuator] = np.interp(time, control.times, control.values)
        for name, value in self.hand.controls.items():
            self._data.ctrl[self._model.actuator(name).id] = value

    def _require_finite(self, time: float) -> None:
        state = np.concatenate((self._data.qpos, self._data.qvel, self._data.act))
        if np.all(np.abs(state) < LARGEST):  # false for NaN
            return
        self._refresh()
        lost = [
            solid.name
            for solid, at in zip(self.solids, self.poses(), strict=True)
            if not all(np.all(np.abs(u) < LARGEST) for u in (at.position, at.velocity, at.omega))
        ]
        name = lost[0] if lost else "a joint"
        raise LostBody(
            f"{name} has no finite place or velocity at t = {time:.6g} s: check masses, gains and velocities"
        )

    def _refresh(self) -> None:
        """Derive from the positions and velocities of the joints what the methods above need."""
        model, data = self._model, self._data
        self._begin_step()
        if self._stiffen():
            self._begin_step()
        self._set_controls(data.time)
        self._mj.mj_fwdActuation(model, data)
        kept = data.qacc_warmstart.copy()  # of the engine's own last step
        self._mj.mj_fwdAcceleration(model, data)
        self._mj.mj_fwdConstraint(model, data)
        data.qacc_warmstart[:] = kept
        self._dynamics.update(model.opt.timestep, constraints_of(self._mj, model, data))


def _half(solid: Solid) -> float:
    """Return half of the smallest extent of a body that is not flat [m]."""
    half = 0.5 * np.ptp(solid.mesh.surface.vertices, axis=0) if solid.mesh else solid.half
    return float(half[half > 0.0].min(initial=math.inf))
