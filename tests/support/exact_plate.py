"""Reference plate solutions by other methods than the package's."""

import math
from functools import lru_cache

import numpy as np
from mpmath import cos, cosh, exp, mp, mpf, pi, sin, sinh, sqrt
from scipy.linalg import eigh
from scipy.optimize import brentq

DIGITS = 50


def navier_modes(plate, f_max_hz):
    """Yield (m, n, omega) of simply supported modes in 50 digits."""
    mp.dps = DIGITS
    a, b, h, nu = (mpf(x) for x in (plate.length_m, plate.width_m, plate.thickness_m, plate.poisson_ratio))
    rigidity = mpf(plate.youngs_modulus_pa) * h**3 / (12 * (1 - nu**2))
    c = sqrt(rigidity / (mpf(plate.density_kg_per_m3) * h))
    reach = int(max(a, b) * sqrt(2 * pi * f_max_hz / c) / pi) + 2
    pairs = ((m, n) for m in range(1, reach) for n in range(1, reach))
    modes = [(m, n, c * pi**2 * ((m / a) ** 2 + (n / b) ** 2)) for m, n in pairs]
    return [mode for mode in modes if mode[2] <= 2 * pi * mpf(f_max_hz) * (1 + mpf(10) ** -13)]


def swing(omega, tau_s, time, quantity="displacement"):
    """Return an oscillator's impulse response in 50 digits."""
    decay = mpf(0) if math.isinf(tau_s) else 1 / mpf(tau_s)
    gap = omega**2 - decay**2
    w = sqrt(abs(gap))
    s, c = (sin(w * time), cos(w * time)) if gap > 0 else (sinh(w * time), cosh(w * time))
    return exp(-decay * time) * (s / w if quantity == "displacement" else c - decay * s / w)


def navier_response(plate, source, point, tau_s, f_max_hz, rate_hz, samples, quantity="displacement"):
    """Return `impulse_responses` of a simply supported plate in 50 digits."""
    modes = navier_modes(plate, f_max_hz)
    a, b = mpf(plate.length_m), mpf(plate.width_m)
    mass = mpf(plate.density_kg_per_m3) * mpf(plate.thickness_m) * a * b
    weights = [4 * _shape(m, n, source, a, b) * _shape(m, n, point, a, b) / mass for m, n, _ in modes]
    out = []
    for sample in samples:
        time = mpf(int(sample)) / mpf(rate_hz)
        swings = (swing(omega, tau_s, time, quantity) for _, _, omega in modes)
        out.append(float(sum(w * g for w, g in zip(weights, swings, strict=True)) / mpf(rate_hz)))
    return np.array(out)


def _shape(m, n, at, a, b):
    return sin(m * pi * mpf(at[0]) / a) * sin(n * pi * mpf(at[1]) / b)


@lru_cache
def levy_modes(plate, f_max_hz):
    """(omega, shape(x, y)) of a plate supported at x = 0 and x = a, free or clamped at y = 0 and y = b: by Levy.

    Along x a sine; across, cos(p s) and cosh(q s) (or sin and sinh) with p^2 = k^2 - mu^2, q^2 = k^2 + mu^2, whose
    moment and edge force, or displacement and slope, vanish at s = +-b/2. Edge waves of free edges have p^2 < 0.
    """
    free = plate.boundary[1] == "F"
    residual, lowest = (_free_edge, 0.5) if free else (_clamped_edge, 1 + 1e-9)
    k_max = math.sqrt(2 * math.pi * f_max_hz / plate.wave_constant_m2_per_s)
    found = []
    for m in range(1, int(k_max * plate.length_m * 1.1 / math.pi) + 2):
        mu = m * math.pi / plate.length_m
        for odd in (False, True):
            k = np.linspace(lowest * mu, max(k_max, lowest * mu), 2000)
            edge = np.array([residual(x, mu, plate, odd) for x in k])
            for i in np.flatnonzero(np.sign(edge[1:]) != np.sign(edge[:-1])):
                root = brentq(residual, k[i], k[i + 1], args=(mu, plate, odd), xtol=1e-14 * k_max, rtol=1e-15)
                found.append((plate.wave_constant_m2_per_s * root**2, _levy_shape(root, mu, plate, odd)))
    return sorted(found, key=lambda mode: mode[0])


def _free_edge(k, mu, plate, odd):
    """Vanishes at the modes; even in p, so real for edge waves too; scaled by cosh(q b / 2)."""
    nu, half = plate.poisson_ratio, plate.width_m / 2
    p, q = np.sqrt(complex(k**2 - mu**2)), math.sqrt(k**2 + mu**2)
    moment, force = (p**2 + nu * mu**2), (p**2 + (2 - nu) * mu**2)
    far_moment, far_force = q**2 - nu * mu**2, (q**2 - (2 - nu) * mu**2) * q
    scale = np.exp(-abs(p.imag) * half)
    if odd:
        ratio = np.sin(p * half) / p if p else half
        value = far_force * moment * ratio - force * np.cos(p * half) * far_moment * math.tanh(q * half)
    else:
        value = far_moment * force * p * np.sin(p * half) + far_force * math.tanh(q * half) * moment * np.cos(p * half)
    return float((value * scale).real)


def _clamped_edge(k, mu, plate, odd):
    """Vanishes at the modes; scaled as `_free_edge`."""
    half = plate.width_m / 2
    p, q = math.sqrt(k**2 - mu**2), math.sqrt(k**2 + mu**2)
    if odd:
        return math.cos(p * half) * math.tanh(q * half) - q * math.sin(p * half) / p
    return p * math.sin(p * half) + q * math.tanh(q * half) * math.cos(p * half)


def _levy_shape(k, mu, plate, odd):
    nu, half = plate.poisson_ratio, plate.width_m / 2
    p, q = np.sqrt(complex(k**2 - mu**2)), math.sqrt(k**2 + mu**2)
    near = np.sin if odd else np.cos
    free = plate.boundary[1] == "F"
    share = near(p * half) * ((p**2 + nu * mu**2) / (q**2 - nu * mu**2) if free else -1)

    def across(y):
        s = np.asarray(y, float) - half
        sign = -1 if odd else 1
        end = (
            np.exp(q * (np.abs(s) - half))
            * (1 + sign * np.exp(-2 * q * np.abs(s)))
            / (1 + sign * math.exp(-2 * q * half))
        )
        raw = near(p * s) + share * end * (np.where(s < 0, -1, 1) if odd else 1)
        return (raw / 1j if odd and p.real == 0 else raw).real

    nodes, weights = np.polynomial.legendre.leggauss(200)
    mean_square = np.sum(weights * across(half * (nodes + 1)) ** 2) / 2
    return lambda x, y: math.sqrt(2 / mean_square) * math.sin(mu * x) * across(y)


def dense_ritz(plate, degree):
    """(omega, shape(x, y)) of an entirely free plate: products of Legendre polynomials, every integral by Gauss's rule
    and one dense eigenproblem.
    """
    nodes, weights = np.polynomial.legendre.leggauss(degree + 4)
    norm = np.sqrt(np.arange(degree + 1) + 0.5)

    def derivative(order, s):
        coefficients = np.polynomial.legendre.legder(np.diag(norm), order) if order else np.diag(norm)
        return np.atleast_2d(np.polynomial.legendre.legval(np.asarray(s, float), coefficients))

    parts = [derivative(order, nodes) for order in range(3)]
    of = {(i, j): (parts[i] * weights) @ parts[j].T for i in range(3) for j in range(3)}
    gx, gy = 2 / plate.length_m, 2 / plate.width_m
    nu, stiff = plate.poisson_ratio, plate.bending_rigidity_n_m

    def both(x, y):
        return np.kron(of[x], of[y])

    bent = gx**4 * both((2, 2), (0, 0)) + gy**4 * both((0, 0), (2, 2))
    mixed = nu * (both((2, 0), (0, 2)) + both((0, 2), (2, 0))) + 2 * (1 - nu) * both((1, 1), (1, 1))
    square, vectors = eigh(stiff * (bent + gx**2 * gy**2 * mixed), both((0, 0), (0, 0)))
    omega = np.sqrt(np.maximum(square, 0) / plate.area_density_kg_per_m2)

    def shapes(x, y):
        on_x, on_y = (
            derivative(0, [2 * at / side - 1])[:, 0] for at, side in ((x, plate.length_m), (y, plate.width_m))
        )
        return 2 * vectors.T @ np.kron(on_x, on_y)

    return omega, shapes


def modal_response(omega, there, here, mass_kg, tau_s, rate_hz, n_samples):
    """Sum of damped sinusoids at equal steps, written out; slow modes creep."""
    t, a = np.arange(n_samples) / rate_hz, 1 / tau_s
    out = np.zeros(n_samples)
    for w, weight in zip(omega, np.multiply(there, here), strict=True):
        damped = np.sqrt(complex(w**2 - a**2))
        out += weight * (np.exp(-a * t) * np.sin(damped * t) / damped).real
    return out / mass_kg / rate_hz
