"""Bogner-Fox-Schmit elements of scikit-fem: a peer of the modes of a free plate."""

import numpy as np
from numpy.typing import NDArray

from tactometry.stimuli.time_reversal import Plate


def bogner_fox_schmit_hz(plate: Plate, n_x: int, n_y: int, n_modes: int) -> NDArray[np.float64]:
    """Kirchhoff's bilinear form, natural edges, shift-inverted Lanczos; the rigid modes come first."""
    from scipy.sparse.linalg import eigsh
    from skfem import Basis, BilinearForm, ElementQuadBFS, MeshQuad
    from skfem.helpers import dd, ddot, trace

    mesh = MeshQuad.init_tensor(np.linspace(0, plate.length_m, n_x + 1), np.linspace(0, plate.width_m, n_y + 1))
    basis, nu = Basis(mesh, ElementQuadBFS()), plate.poisson_ratio

    @BilinearForm
    def bending(u, v, w):  # type: ignore[no-untyped-def]
        del w
        return (1 - nu) * ddot(dd(u), dd(v)) + nu * trace(dd(u)) * trace(dd(v))

    @BilinearForm
    def inertia(u, v, w):  # type: ignore[no-untyped-def]
        del w
        return u * v

    lowest = eigsh(bending.assemble(basis), n_modes, inertia.assemble(basis), sigma=-1.0, return_eigenvectors=False)
    return np.sort(plate.wave_constant_m2_per_s * np.sqrt(np.maximum(lowest, 0)) / (2 * np.pi))
