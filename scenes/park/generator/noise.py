"""Band-limited random fields on a square, made in Fourier space: isotropic, zero mean, unit variance, seeded."""

import numpy as np


class NoiseField:
    """A periodic field over `extent_m`, centred on the scene origin, with power-law spectrum between two
    wavelengths."""

    def __init__(self, seed, extent_m, longest_m, shortest_m, slope=3.0, size=1024):
        rng = np.random.default_rng(seed)
        self.extent_m, self.size = extent_m, size
        frequency = np.hypot(
            *np.meshgrid(np.fft.fftfreq(size, extent_m / size), np.fft.rfftfreq(size, extent_m / size), indexing="ij")
        )
        with np.errstate(divide="ignore"):
            amplitude = np.where(
                (frequency >= 1 / longest_m) & (frequency <= 1 / shortest_m), frequency ** (-slope / 2), 0.0
            )
        white = np.fft.rfft2(rng.standard_normal((size, size)))
        field = np.fft.irfft2(white * amplitude, s=(size, size))
        self.field = (field - field.mean()) / field.std()

    def __call__(self, x_m, y_m):
        """Bilinear value at scene positions (arrays of one shape)."""
        u = (np.asarray(x_m) / self.extent_m + 0.5) * self.size
        v = (np.asarray(y_m) / self.extent_m + 0.5) * self.size
        i, j = np.floor(u).astype(int), np.floor(v).astype(int)
        fu, fv = u - i, v - j
        i0, i1, j0, j1 = i % self.size, (i + 1) % self.size, j % self.size, (j + 1) % self.size
        f = self.field
        return (1 - fv) * ((1 - fu) * f[j0, i0] + fu * f[j0, i1]) + fv * ((1 - fu) * f[j1, i0] + fu * f[j1, i1])


def smoothstep(low, high, value):
    """0 below low, 1 above high, cubic between."""
    t = np.clip((value - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)
