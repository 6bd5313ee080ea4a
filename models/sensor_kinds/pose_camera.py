"""A camera that sees the pose of a target on the body."""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import PositiveFloat

from models.rotation import axis_difference, rotation_matrix, rotation_vector
from models.sensor_kinds.mounted import MountedSensor
from models.sensor_kinds.reading import MovingBody, SymbolicReading


class PoseCamera(MountedSensor):
    """Pose of a target on the pen in the world: position, m, and rotation vector, rad.

    The rotation vector is that of the matrix from target axes to world axes.
    """

    sees_pose: ClassVar[bool] = True
    kind: Literal["pose_camera"] = "pose_camera"
    position_std_m: PositiveFloat
    orientation_std_rad: PositiveFloat

    @property
    def sees_position(self) -> bool:
        """It does, wherever the target is."""
        return True

    @property
    def reading_axes(self) -> tuple[tuple[str, str], ...]:
        """Position and rotation vector."""
        return tuple((axis, "m") for axis in "xyz") + tuple((f"r{a}", "rad") for a in "xyz")

    def symbolic_reading(self, body: MovingBody, bias: ca.SX) -> SymbolicReading:
        """Position plainly; orientation by the rotation vector between seen and predicted.

        A body that cannot spin is compared by the direction of its axis only,
        because a seen spin would otherwise be explained by tilting the axis.
        """
        world_to_body = body.rigid.world_to_body
        target_to_body = ca.DM(self.sensor_to_body)
        position = body.rigid.point(ca.SX(self.position_m))
        h = ca.vertcat(position, rotation_vector(world_to_body.T @ target_to_body))

        def residual(y: ca.SX) -> ca.SX:
            seen_body_to_world = rotation_matrix(y[3:6]) @ target_to_body.T
            seen_in_body = world_to_body @ seen_body_to_world
            if body.has_spin:
                turn = rotation_vector(seen_in_body)
            else:
                turn = axis_difference(seen_in_body[:, 2])
            return ca.vertcat(y[:3] - position, turn)

        n_turn = 3 if body.has_spin else 2
        noise_std = np.array([self.position_std_m] * 3 + [self.orientation_std_rad] * n_turn)
        row_units = ("m",) * 3 + ("rad",) * n_turn
        return SymbolicReading(h, noise_std, residual, row_units=row_units)
