"""What joints, motors, contacts and limits add to the inertia that an impulse meets within a step."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def damping(mj: Any, model: Any, data: Any) -> Array | None:
    """Return the damping D (nv, nv) of joints and of motors at their joints; None if there is none.

    The force of an actuator falls by -biasprm[2] for each unit of its speed (MuJoCo's affine bias), unless
    it is at its limit.
    """
    if not model.nu and not model.dof_damping.any():
        return None
    found = np.diag(model.dof_damping).copy()
    for i in range(model.nu):
        rate = -float(model.actuator_biasprm[i, 2])
        low, high = model.actuator_forcerange[i]
        held = model.actuator_forcelimited[i] and not low < data.actuator_force[i] < high
        if model.actuator_biastype[i] == mj.mjtBias.mjBIAS_AFFINE and rate > 0.0 and not held:
            moment = np.zeros(model.nv)
            begin, count = data.moment_rowadr[i], data.moment_rownnz[i]
            rows = slice(begin, begin + count)
            moment[data.moment_colind[rows]] = data.actuator_moment[rows]
            found += rate * np.outer(moment, moment)
    return found if found.any() else None


def constraint_inertia(mj: Any, model: Any, data: Any) -> Array | None:
    """Return K = sum of J^T D J (nv, nv) over the constraints that hold in `data`; None if there are none.

    A constraint of the engine answers an acceleration a with the force D (a_ref - J a) as long as it holds
    (MuJoCo's documentation, computation, soft constraints). Of contacts the normal counts alone: friction
    holds only up to its cone. Equalities hold always, limits and contacts where the bodies press on them.
    """
    if not data.nefc:
        return None
    kinds = mj.mjtConstraint
    single = (kinds.mjCNSTR_EQUALITY, kinds.mjCNSTR_LIMIT_JOINT, kinds.mjCNSTR_LIMIT_TENDON)
    counts = np.isin(data.efc_type, [int(kind) for kind in single])
    normals = np.asarray(data.contact.efc_address)
    counts[normals[normals >= 0]] = True
    counts &= np.asarray(data.efc_state) != int(mj.mjtConstraintState.mjCNSTRSTATE_SATISFIED)
    rows = np.flatnonzero(counts)
    if not rows.size:
        return None
    J = np.zeros((data.nefc, model.nv))
    if mj.mj_isSparse(model):
        mj.mju_sparse2dense(J, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind)
    else:
        J[:] = data.efc_J.reshape(data.nefc, model.nv)
    found = np.zeros((model.nv, model.nv))
    mj.mju_sqrMatTD(found, np.ascontiguousarray(J[rows]), np.array(data.efc_D[rows]))
    return found
