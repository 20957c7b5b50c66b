"""A problem linearised along a roll-out, and what eliminating its states leaves.

The states move by dx_k = G_k v with the inputs' change v (N nu), G_0 = 0, and
G_{k+1} = F_k Z_k, where Z_k = (G_k; E_k) gives the change of stage k's state and input.
"""

from dataclasses import dataclass

import numpy as np

from ..ground.arrays import Array


@dataclass(frozen=True, eq=False)
class Linearization:
    """Derivatives along a roll-out."""

    F: Array
    """d x_next / d(x, u), shape (N, nx, nx + nu)."""
    r: Array
    """Residuals, shape (N, nr)."""
    R: Array
    """d r / d(x, u), shape (N, nr, nx + nu)."""
    r_end: Array
    R_end: Array

    def sensitivities(self) -> tuple[Array, Array]:
        """Z, shape (N, nx + nu, N nu), and G_N, shape (nx, N nu)."""
        N, nx, nz = self.F.shape
        nu = nz - nx
        Z, eye = np.zeros((N + 1, nz, N * nu)), np.eye(nu)
        for k in range(N):
            now = (k + 1) * nu
            Z[k, nx:, k * nu : now] = eye
            np.matmul(self.F[k], Z[k, :, :now], out=Z[k + 1, :nx, :now])
        return Z[:-1], Z[-1][:nx]

    def costate(self, by_state: Array) -> Array:
        """Derivative of the Lagrangian by each state through all that follows, (N + 1, nx).

        `by_state` is what the limits' multipliers add, shape (N + 1, nx).
        """
        N, nx, _ = self.F.shape
        adjoint = by_state + np.concatenate(
            [np.einsum("kr,krz->kz", self.r, self.R[:, :, :nx]), (self.r_end @ self.R_end)[None]]
        )
        for k in range(N - 1, 0, -1):
            adjoint[k] += adjoint[k + 1] @ self.F[k][:, :nx]
        return adjoint

    def gradient(self, Z: Array, G_end: Array) -> Array:
        """Derivative of the cost by all inputs, shape (N nu,)."""
        pull = np.einsum("kr,krz->kz", self.r, self.R)
        along: Array = pull.ravel() @ Z.reshape(-1, Z.shape[2])
        return along + (self.r_end @ self.R_end) @ G_end


def condensed(Z: Array, G_end: Array, W: Array, W_end: Array) -> Array:
    """Hessian by the inputs, sum_k Z_k' W_k Z_k + G_N' W_N G_N, from the stages' Hessians."""
    n = Z.shape[2]
    return Z.reshape(-1, n).T @ (W @ Z).reshape(-1, n) + G_end.T @ W_end @ G_end
