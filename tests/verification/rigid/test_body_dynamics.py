"""What the core makes of the engine's arrays, against the engine's own functions of dense matrices."""

import numpy as np
import pytest
from verification.loose import bodies_of, exchange, run

from neve._core import BodyMotion
from neve.rigid.engine import engine

BOX = {"shape": "box", "size": [0.3, 0.3, 0.3], "mass": 2.0}
GROUND = [{"shape": "plane"}]
ARM = [
    {**BOX, "center": [0.0, 0.0, 2.0], "joint": "hinge", "axis": [0, 1, 0], "anchor": [0.0, 0.0, 2.3],
     "spin": [0.0, 2.0, 0.0], "motor": {"target": 1.0, "gain": 5.0, "limit": 50.0}},
    {**BOX, "center": [0.0, 0.0, 1.5], "joint": "hinge", "axis": [1, 1, 0], "anchor": [0.0, 0.0, 1.7],
     "spin": [1.0, 1.0, 0.0], "parent": 0, "limits": [-1, 40]},
    {**BOX, "center": [5.0, 0.0, 2.0], "spin": [3.0, -2.0, 1.0], "velocity": [1.0, 0.0, 2.0]},
    {**BOX, "center": [8.0, 0.0, 0.14999]},
]  # fmt: skip
"""A double pendulum with a motor, its second joint at its limit, a body that tumbles, one on the ground."""


def grid(count, gap):
    """Boxes on the ground, side by side."""
    return [{**BOX, "center": [gap * (i % 4), gap * (i // 4), 0.14999]} for i in range(count)]


def dense(rigid):
    """A = J (M + h D + K)^-1 J^T and J qacc + dJ/dt qvel, of whole matrices, with the engine's Jacobians."""
    mj, model, data = engine(), rigid._model, rigid._data
    n, nv = len(rigid.solids), model.nv
    J, turned = np.zeros((n, 2, 3, nv)), np.zeros((n, 2, 3, nv))
    for i, (solid, x) in enumerate(zip(rigid._assembly.attachments, rigid.motion.centres, strict=True)):
        mj.mj_jac(model, data, *J[i], x, solid.body)
        mj.mj_jacDot(model, data, *turned[i], x, solid.body)
    inertia, damped = np.zeros((nv, nv)), np.diag(model.dof_damping)
    mj.mj_fullM(model, data, inertia)
    for i in range(model.nu):
        row = slice(data.moment_rowadr[i], data.moment_rowadr[i] + data.moment_rownnz[i])
        moment = np.zeros(nv)
        moment[data.moment_colind[row]] = data.actuator_moment[row]
        damped -= model.actuator_biasprm[i, 2] * np.outer(moment, moment)
    inertia += model.opt.timestep * damped
    forces = data.qfrc_smooth + data.qfrc_constraint
    rates = np.linalg.solve(inertia, forces) if damped.any() else data.qacc
    rows = np.zeros((data.nefc, nv))
    if mj.mj_isSparse(model):
        mj.mju_sparse2dense(rows, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    else:
        rows[:] = data.efc_J.reshape(data.nefc, nv)
    normals = {int(contact.efc_address) for contact in data.contact}
    limits = int(mj.mjtConstraint.mjCNSTR_LIMIT_JOINT)
    holds = data.efc_state != int(mj.mjtConstraintState.mjCNSTRSTATE_SATISFIED)
    for i in range(data.nefc):
        if holds[i] and (i in normals or data.efc_type[i] == limits):
            inertia += data.efc_D[i] * np.outer(rows[i], rows[i])
    J, turned = J.reshape(6 * n, nv), turned.reshape(6 * n, nv)
    return J @ np.linalg.solve(inertia, J.T), (J @ rates + turned @ data.qvel).reshape(n, 6)


@pytest.mark.parametrize(
    ("tables", "groups"),
    [(ARM, 3), (grid(4, 1.0), 4), (grid(12, 1.0), 12), ([BOX], 1)],
    ids=["arm", "dense", "sparse", "one"],
)
def test_motion_is_that_of_dense_matrices(tables, groups):
    """Mobility and acceleration are those of the whole matrices, though only what moves together is solved.

    Both ways round: 1e3 eps of the largest number of a body, with conditions of some 1e2 at contacts (their
    D is 1e5 times the inertia, along one direction each).
    """
    rigid = bodies_of(tables, GROUND)
    run(rigid, 1e-4, 3)
    mobility, acceleration = dense(rigid)
    assert np.abs(rigid.motion.mobility - mobility).max() < 1e-9 * np.abs(mobility).max()
    assert np.abs(rigid.motion.acceleration - acceleration).max() < 1e-9 * np.abs(acceleration).max()
    assert rigid.motion.groups == groups


def test_engine_stores_many_joints_sparsely():
    """Of twelve bodies the Jacobian of constraints is sparse, of four it is not: both are tested above."""
    assert engine().mj_isSparse(bodies_of(grid(12, 1.0), GROUND)._model)
    assert not engine().mj_isSparse(bodies_of(grid(4, 1.0), GROUND)._model)


def test_bodies_that_touch_move_together():
    """A box on another is of its group as long as it presses on it."""
    pile = [{**BOX, "center": [0.0, 0.0, 0.14999]}, {**BOX, "center": [0.0, 0.0, 0.44997]}]
    rigid = bodies_of(pile, GROUND)
    run(rigid, 1e-4, 3)
    assert rigid.motion.groups == 1
    mobility, _ = dense(rigid)
    assert np.abs(rigid.motion.mobility - mobility).max() < 1e-9 * np.abs(mobility).max()
    assert np.abs(mobility[:6, 6:]).max() > 1e-3 * np.abs(mobility).max()


def test_force_without_a_number_moves_nothing():
    """The first body whose exchange is not finite is named, and no force has been applied to any."""
    rigid = bodies_of(grid(3, 1.0))
    bad = exchange([1.0] * 6, [0.0, np.nan, 0.0, 0.0, 0.0, 0.0], [np.inf] * 6)
    assert rigid._dynamics.apply(bad, 1e-4) == 1
    assert not rigid._data.xfrc_applied.any()


def test_arrays_that_do_not_fit_are_refused():
    """A mobility needs six rows for each body; dynamics need each array by its name and type."""
    one = (np.zeros((1, 3)), np.eye(3)[None], np.zeros((1, 6)))
    with pytest.raises(ValueError, match="a row for each body"):
        BodyMotion(*one, np.zeros((5, 6)), np.zeros((1, 6)))
    motion = BodyMotion(*one, 2.0 * np.eye(6), np.ones((1, 6)))
    assert np.array_equal(motion.mobility, 2.0 * np.eye(6))
    assert np.array_equal(motion.acceleration, np.ones((1, 6)))
