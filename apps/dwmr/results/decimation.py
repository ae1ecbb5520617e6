"""Decimation of long signals for plots that keeps every peak."""

from __future__ import annotations

import numpy as np

from dwmr.core.arrays import FloatArray


def kept(signal: FloatArray, buckets: int) -> np.ndarray:
    """Return which samples draw the same picture: the least and the greatest of every bucket, first and last.

    Every peak stays at its own time, so that chattering shows as the band it fills.

    Args:
        signal: Shape (samples,), any unit.
        buckets: Stretches of equal length; a picture needs about one for each of its columns of pixels.

    Returns:
        Increasing indices, shape (k,) with k <= 2 buckets + 2, or all where there are no more samples than that.
    """
    count = len(signal)
    if count <= 2 * buckets + 2:
        return np.arange(count)
    size = -(-count // buckets)
    # the last bucket is filled up with the last sample
    rows = np.pad(signal, (0, -count % size), mode="edge").reshape(-1, size)
    starts = np.arange(len(rows)) * size
    found = np.concatenate([[0, count - 1], starts + rows.argmin(axis=1), starts + rows.argmax(axis=1)])
    return np.unique(np.minimum(found, count - 1))


def thin(t: FloatArray, signal: FloatArray, buckets: int) -> tuple[FloatArray, FloatArray]:
    """Return times and values of the samples that are kept, both of shape (k,)."""
    index = kept(signal, buckets)
    return t[index], signal[index]
