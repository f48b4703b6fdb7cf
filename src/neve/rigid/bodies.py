"""Rigid bodies that snow pushes: MuJoCo moves them, their joints and their contacts with one another."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.motion import pose
from neve.colliders.solid import Solid, solid_of
from neve.geometry.pose import Pose, cross
from neve.reproducible import product
from neve.rigid.assembly import Assembly, assemble
from neve.rigid.constraint_inertia import constraint_inertia, damping
from neve.rigid.coupled_bodies import LostBody
from neve.rigid.engine import engine, forget, quaternion
from neve.rigid.overlap import require_apart
from neve.rigid.products import solved, times, times_transposed
from neve.rigid.robot_solids import robot_solids
from neve.rigid.soundness import require_few, require_movable
from neve.scene.schema.scene import Scene

Array = NDArray[np.float64]

MAX_STEP = 5e-4
"""Longest step of the engine [s]."""
FIRST_STEP = 1e-4
"""Length of the engine's step that is assumed before the first one [s]."""
TURNED, TURNED_BACK = np.array((1, 2, 0)), np.array((2, 0, 1))
"""Components of (a x b)_k = a_(k+1) b_(k+2) - a_(k+2) b_(k+1)."""
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
        held = self._assembly.attachments
        self._carriers = [attachment.body for attachment in held]
        axes = [np.column_stack((attachment.rotation, attachment.position)) for attachment in held]
        self._frames = np.array(axes).reshape(-1, 3, 4)
        """Axes and origin of each solid's frame, as the body that carries it has them."""
        self._jacobian = np.zeros((6 * len(held), self._model.nv))
        self._data = self._mj.MjData(self._model)
        self._signature = int(self._mj.mjtState.mjSTATE_INTEGRATION)
        self._model.opt.timestep = FIRST_STEP
        self._data.qpos[:] = self._assembly.start
        self._data.qvel[:] = self._assembly.speeds
        self._refresh()
        require_movable(self._model, self._data)
        require_apart(self._model, self._data)

    def poses(self) -> list[Pose]:
        """Return where the frame of each solid is and how it moves."""
        return [Pose(x, R, rate[:3], rate[3:]) for x, R, rate in zip(*self.placed(), strict=True)]

    def placed(self) -> tuple[Array, Array, Array]:
        """Return the same in arrays: positions (n, 3), rotations (n, 3, 3), both velocities (n, 6)."""
        rates = times(self._jacobian, self._data.qvel).reshape(-1, 6)
        return self._positions, self._rotations, rates

    def mobility(self) -> Array:
        """Return A (6 n, 6 n) in dU = A dP: how impulses on the solids change their velocities in a step.

        U has six rows a solid: velocity of its frame's origin [m/s] and angular velocity [rad/s]; P: impulse
        at the frame's origin [N s] and moment about it [N m s]. A = J (M + h D + K)^-1 J^T with the Jacobian
        J of U and the mass matrix M of the joints; D is the damping of joints and motors, which the engine
        takes implicitly, h the length of its last step. K is what contacts, limits and equalities add that
        hold now (`constraint_inertia`): a body on the ground yields no more than the ground lets it.
        """
        J = self._jacobian
        held = constraint_inertia(self._mj, self._model, self._data)
        if self._damping is not None or held is not None:
            inertia = self._damped_inertia() + (0.0 if held is None else held)
            moved = solved(inertia, J)
        else:
            moved = np.zeros_like(J)
            if J.size:
                self._mj.mj_solveM(self._model, self._data, moved, J)
        A = times_transposed(J, moved)
        return np.asarray(0.5 * (A + A.T))

    def free_acceleration(self) -> Array:
        """Return the accelerations that all but the snow gives the solids now (n, 6) [m/s2, rad/s2].

        Of frames' origins and of turning: gravity, contacts among bodies, motors as of the engine's next step
        if that is as long as the last one.
        """
        mj, model, data = self._mj, self._model, self._data
        rates = np.array(data.qacc)
        if self._damping is not None:
            forces = data.qfrc_smooth + data.qfrc_constraint
            rates = solved(self._damped_inertia(), forces[None])[0]
        change = np.empty_like(self._jacobian)
        parts = change.reshape(len(self.solids), 2, 3, model.nv)
        for (linear, angular), x, body in zip(parts, self._positions, self._carriers, strict=True):
            mj.mj_jacDot(model, data, linear, angular, x, body)
        return np.asarray((times(self._jacobian, rates) + times(change, data.qvel)).reshape(-1, 6))

    def advance(self, dt: float, exchanged: Array, time: float) -> None:
        """Move the bodies from `time` on by `dt` [s] under what they exchanged with the snow.

        exchanged: (n, 7), impulse of the snow on each solid [N s], its moment about the frame's origin
        [N m s], work [J] (not used). It acts as a constant force and torque. The engine takes equal steps of
        at most MAX_STEP.

        Errors: LostBody if what was exchanged, or a position or a velocity afterwards, is not finite.
        """
        model, data = self._model, self._data
        wrenches = np.asarray(exchanged, dtype=np.float64)[:, :6] / dt
        if not np.isfinite(wrenches).all():
            lost = self.solids[int(np.argmin(np.isfinite(wrenches).all(axis=1)))]
            raise LostBody(f"the snow pushes {lost.name} without a finite force at t = {time:.6g} s")
        if abs(time - data.time) > 1e-9 * max(1.0, time):
            data.time = time
            self._refresh()
        count = max(1, math.ceil(dt / MAX_STEP - 1e-9))
        model.opt.timestep = dt / count
        self._apply(wrenches)
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
        state = other.save()
        if len(state["engine"]) == self._mj.mj_stateSize(self._model, self._signature) + 1:
            return self.restore(state)
        for name in ("qpos", "qvel", "act", "qacc_warmstart"):
            getattr(self._data, name)[:] = getattr(other._data, name)
        self._data.time = other._data.time
        self._model.opt.timestep = other._model.opt.timestep
        self._refresh()

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

    def _apply(self, wrenches: Array) -> None:
        """Apply a force at each solid's frame and a torque about it, as they stand now [N, N m], (n, 6)."""
        data = self._data
        force, arm = wrenches[:, :3], self._positions - data.xipos[self._carriers]
        whole = np.array(wrenches)
        whole[:, 3:] += arm[:, TURNED] * force[:, TURNED_BACK] - arm[:, TURNED_BACK] * force[:, TURNED]
        data.xfrc_applied[:] = 0.0
        np.add.at(data.xfrc_applied, self._carriers, whole)

    def _begin_step(self) -> None:
        """Do the first half of a step of the engine: positions, velocities, contacts, and what these aim at.

        The engine takes mocap bodies to be at rest. What a contact aims at, -B u - K r with the velocity u
        of one surface past the other, is therefore corrected by the velocity of a moving collider's surface.
        """
        model, data = self._model, self._data
        motions: dict[int, Pose] = {}
        for collider, mocap, geom in self._assembly.scripted:
            motions[geom] = now = pose(collider, data.time)
            data.mocap_pos[mocap] = now.position
            data.mocap_quat[mocap] = quaternion(now.rotation)
        self._mj.mj_step1(model, data)
        for contact in data.contact if motions else ():
            if contact.efc_address < 0:
                continue
            surface = np.zeros(3)
            for geom, sign in zip(contact.geom, (-1.0, 1.0), strict=True):
                if at := motions.get(int(geom)):
                    surface += sign * (at.velocity + cross(at.omega, contact.pos - at.position))
            rows = slice(contact.efc_address, contact.efc_address + min(contact.dim, 3))
            along = product(contact.frame.reshape(3, 3)[: min(contact.dim, 3)], surface)
            data.efc_aref[rows] -= data.efc_KBIP[rows, 1] * along

    def _set_controls(self, time: float) -> None:
        for control in self._assembly.controls:
            self._data.ctrl[control.actuator] = np.interp(time, control.times, control.values)

    def _damped_inertia(self) -> Array:
        """Return M + h D (nv, nv), with which the engine's last step changed velocities."""
        inertia = np.zeros((self._model.nv, self._model.nv))
        self._mj.mj_fullM(self._model, self._data, inertia)
        return inertia if self._damping is None else inertia + self._model.opt.timestep * self._damping

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
        self._set_controls(data.time)
        self._mj.mj_fwdActuation(model, data)
        kept = data.qacc_warmstart.copy()  # of the engine's own last step
        self._mj.mj_fwdAcceleration(model, data)
        self._mj.mj_fwdConstraint(model, data)
        data.qacc_warmstart[:] = kept
        self._damping = damping(self._mj, model, data)
        placed = product(data.xmat[self._carriers].reshape(-1, 3, 3), self._frames)
        self._positions = data.xpos[self._carriers] + placed[..., 3]
        self._rotations = np.ascontiguousarray(placed[..., :3])
        parts = self._jacobian.reshape(len(self.solids), 2, 3, model.nv)
        for (linear, angular), x, body in zip(parts, self._positions, self._carriers, strict=True):
            self._mj.mj_jac(model, data, linear, angular, x, body)
