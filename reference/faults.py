"""Faults of channels, put into records and into measured responses."""

import numpy as np

#: Level of the noise of a dead channel, of the rms of its signal: its amplifier goes on.
NOISE = 1e-3


def late(values, freq_hz, delay_s):
    """A channel that was sampled later by ``delay_s``: spectra or responses over ``freq_hz``."""
    return values * np.exp(-2j * np.pi * freq_hz * delay_s)


def integrated(values, freq_hz):
    """A velocity among accelerations."""
    return values / (2j * np.pi * np.maximum(freq_hz, 1e-3))


def noise_only(values, rng):
    """A dead channel: white noise in its place."""
    level = NOISE * np.sqrt(np.mean(np.abs(values) ** 2))
    parts = rng.standard_normal((2, values.size))
    return level * ((parts[0] + 1j * parts[1]) if np.iscomplexobj(values) else parts[0])


def filtered(x, fs_hz, change):
    """A record with ``change(spectrum, freq_hz)`` in its spectrum."""
    spectrum = change(np.fft.rfft(x), np.fft.rfftfreq(x.size, 1.0 / fs_hz))
    return np.fft.irfft(spectrum, x.size)


def clipped(x, share=1e-3):
    """A record whose largest ``share`` of samples is cut off."""
    limit = np.quantile(np.abs(x), 1.0 - share)
    return np.clip(x, -limit, limit)


def hum(n_channels, n, fs_hz, base_hz, rng, multiples=(1, 2, 3), wander_hz=0.005):
    """Mains hum of unit rms, (n_channels, n): every channel with multiples of its own size and phase."""
    t = np.arange(n) / fs_hz
    knots = np.arange(0.0, t[-1] + 10.0, 5.0)
    turns = np.cumsum(base_hz + wander_hz * np.interp(t, knots, rng.standard_normal(knots.size))) / fs_hz
    size, phase = rng.uniform(0.3, 1.0, (2, n_channels, len(multiples)))
    size /= np.array(multiples)
    angle = 2 * np.pi * (turns * np.array(multiples)[:, None] + phase[:, :, None])
    total = np.einsum("pk,pkt->pt", size, np.sin(angle))
    return total / total.std()
