"""What the core reads of the rigid-body engine, in the engine's own memory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from neve import _core
from neve.rigid.robot_solids import Attachment

if TYPE_CHECKING:
    from neve._core import BodyDynamics

OF_MODEL = (
    *("body_rootid", "body_parentid", "body_dofadr", "body_dofnum", "dof_parentid", "dof_treeid"),
    *("M_rownnz", "M_rowadr", "M_colind", "dof_damping", "actuator_biastype", "actuator_biasprm"),
    *("actuator_forcelimited", "actuator_forcerange"),
)
OF_DATA = (
    *("xpos", "xmat", "xipos", "subtree_com", "cdof", "cdof_dot", "qvel", "qacc", "qfrc_smooth"),
    *("qfrc_constraint", "M", "actuator_force", "moment_rownnz", "moment_rowadr", "moment_colind"),
    *("actuator_moment", "xfrc_applied"),
)
OF_CONSTRAINTS = ("efc_type", "efc_state", "efc_J", "efc_D")
SPARSE = ("efc_J_rownnz", "efc_J_rowadr", "efc_J_colind")
NONE = np.zeros(0, dtype=np.int32)


def dynamics_of(mj: Any, model: Any, data: Any, held: Sequence[Attachment]) -> BodyDynamics:
    """Return the dynamics of the solids `held` by bodies of the engine, which reads the engine's arrays.

    These keep their place as long as `model` and `data` live, but for those of constraints.
    """
    kinds = mj.mjtConstraint
    whole = (kinds.mjCNSTR_EQUALITY, kinds.mjCNSTR_LIMIT_JOINT, kinds.mjCNSTR_LIMIT_TENDON)
    numbers = {
        "ntree": int(model.ntree),
        "affine": int(mj.mjtBias.mjBIAS_AFFINE),
        "satisfied": int(mj.mjtConstraintState.mjCNSTRSTATE_SATISFIED),
        "whole_kinds": sum(1 << int(kind) for kind in whole),
        "bias_numbers": int(model.actuator_biasprm.shape[1]),
    }
    frames = [np.column_stack((each.rotation, each.position)) for each in held]
    return _core.BodyDynamics(
        {name: getattr(model, name) for name in OF_MODEL} | numbers,
        {name: getattr(data, name) for name in OF_DATA},
        np.array([each.body for each in held], dtype=np.int32),
        np.array(frames, dtype=np.float64).reshape(-1, 3, 4),
    )


def constraints_of(mj: Any, model: Any, data: Any) -> dict[str, Any] | None:
    """Return the engine's constraints of the moment; None if there are none."""
    if not data.nefc:
        return None
    found = {name: getattr(data, name) for name in OF_CONSTRAINTS}
    sparse = mj.mj_isSparse(model)
    found |= {name: getattr(data, name) if sparse else NONE for name in SPARSE}
    return found | {"contact_address": np.ascontiguousarray(data.contact.efc_address, dtype=np.int32)}
