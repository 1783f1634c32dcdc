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
