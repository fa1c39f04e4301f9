"""Time nodes within the pieces of a voltage, independent of its level."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import ComplexArray, FloatArray, IndexArray
from ..skin.relaxation import Relaxations, phi1
from ..waveforms.pieces import Pieces

DECAYED = 40.0
"""Time constants after which a relaxation follows its input: what is left of it is 4e-18."""


class Heights(NamedTuple):
    """Value, slope and sinusoids (n_pieces, n_turns) of a voltage per piece."""

    offsets: FloatArray
    slopes: FloatArray
    amplitudes: ComplexArray


class Phases(NamedTuple):
    """Times of the nodes, and the circuit factors that depend on them.

    Per node the piece that holds it and the time since that started; decay and line factor of each relaxation there,
    (n_relax, n_nodes); the same at the ends of the pieces, with their lengths; the turn of each sinusoid at each node,
    (n_nodes, n_turns), and what each relaxation answers to it, (n_relax, n_turns).
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
    """Return which relaxations move after each node, (n_nodes, n_relax)."""
    return np.asarray(since[:, None] * np.array(relaxations.rates_per_s) < DECAYED * (1 - 1e-9))


def nodes_of(pieces: Pieces, relaxations: Relaxations, t_s: FloatArray) -> FloatArray:
    """Merge requested times, 0, starts of pieces and ends of decays in order."""
    rates = np.array([rate for rate in relaxations.rates_per_s if rate > 0])
    # (n_pieces * n_rates,), and the end of the piece of each: a decay that outlasts its piece ends with it
    decayed = (pieces.starts_s[:, None] + DECAYED / rates[None, :]).ravel()
    ends = np.repeat(np.r_[pieces.starts_s[1:], pieces.end_s], rates.size)
    nodes = np.unique(np.concatenate([[0.0], pieces.starts_s, decayed[decayed < ends], t_s]))
    return np.asarray(nodes[nodes <= t_s[-1]])
