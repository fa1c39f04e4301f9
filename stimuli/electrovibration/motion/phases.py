"""Time nodes of a voltage and their factors, independent of its level."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import ComplexArray, FloatArray, IndexArray
from ..skin.relaxation import Relaxations, phi1
from ..waveforms.pieces import Pieces

DECAYED = 40.0
"""Time constants after which a relaxation follows its input: a remainder of 4e-18."""


class Heights(NamedTuple):
    """Value, slope and sinusoid amplitudes (n_pieces, n_turns) per piece."""

    offsets: FloatArray
    slopes: FloatArray
    amplitudes: ComplexArray


class Phases(NamedTuple):
    """Times of the nodes, and the circuit factors that depend on them.

    For each node: its piece, the time since the start of the piece, and the decay and line factor of each relaxation
    (n_relax, n_nodes). For each piece: its length and the same factors at its end. `turns` are the phasors of the
    sinusoids at the nodes (n_nodes, n_turns), `responses` the response of each relaxation to them (n_relax, n_turns).
    """

    piece: IndexArray
    since: FloatArray
    decay: FloatArray
    line: FloatArray
    spans: FloatArray
    end_decay: FloatArray
    end_line: FloatArray
    turns: ComplexArray
    responses: ComplexArray


def heights(pieces: Pieces) -> Heights:
    return Heights(pieces.offsets_v, pieces.slopes_v_per_s, pieces.harmonics_v)


def phases(pieces: Pieces, relaxations: Relaxations, nodes: FloatArray) -> Phases:
    """Return the phases of nodes (n_nodes,) within the pieces."""
    piece = pieces.index(nodes)
    since = nodes - pieces.starts_s[piece]
    rates = np.array(relaxations.rates_per_s).reshape(-1, 1)
    spans = np.diff(np.r_[pieces.starts_s, pieces.end_s])
    rows = [Relaxations((1.0,), (rate,)).response(pieces.frequencies_hz) for rate in relaxations.rates_per_s]
    return Phases(
        piece,
        since,
        decay=np.exp(-rates * since),
        line=since * phi1(rates * since),
        spans=spans,
        end_decay=np.exp(-rates * spans),
        end_line=spans * phi1(rates * spans),
        turns=np.exp(2j * np.pi * np.multiply.outer(nodes, pieces.frequencies_hz)),
        responses=np.array(rows, dtype=np.complex128).reshape(len(rows), len(pieces.frequencies_hz)),
    )


def moving(since: FloatArray, relaxations: Relaxations) -> NDArray[np.bool_]:
    """Return a mask (n_nodes, n_relax) of relaxations not yet decayed."""
    return np.asarray(since[:, None] * np.array(relaxations.rates_per_s) < DECAYED * (1 - 1e-9))


def nodes_of(pieces: Pieces, relaxations: Relaxations, t_s: FloatArray) -> FloatArray:
    """Return requested times, 0, piece starts and ends of decays, sorted."""
    rates = np.array([rate for rate in relaxations.rates_per_s if rate > 0])
    # (n_pieces * n_rates,); a decay ends at the latest with its piece
    decayed = (pieces.starts_s[:, None] + DECAYED / rates[None, :]).ravel()
    ends = np.repeat(np.r_[pieces.starts_s[1:], pieces.end_s], rates.size)
    nodes = np.unique(np.concatenate([[0.0], pieces.starts_s, decayed[decayed < ends], t_s]))
    return np.asarray(nodes[nodes <= t_s[-1]])
