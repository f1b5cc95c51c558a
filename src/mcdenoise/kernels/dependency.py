"""The fast twin of mutual information: joint histograms of small whole numbers, for all pairs of variables.

With counts n_xy, n_x, n_y of N samples, mu = log N + (sum n_xy log n_xy - sum n_x log n_x - sum n_y log n_y) / N: one
look-up a bin, in a table of n log n.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.kernels.jit import kernel

ROUNDING = 1e-12  # nats, as in rpf.dependency


def information_of_pairs(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Mutual information, in nats, of each column of x (n, a) with each of y (n, b), whole numbers: (a, b), float64.

    Examples
    --------
    >>> x = np.array([[0, 0], [1, 0]])
    >>> information_of_pairs(x, x).round(2)
    array([[0.69, 0.  ],
           [0.  , 0.  ]])
    """
    found = np.zeros((x.shape[1], y.shape[1]))
    if found.size:
        x, y = (np.ascontiguousarray((one - one.min(axis=0)).T, np.uint8) for one in (x, y))
        pair_information(found, x, y, n_log_n(x.shape[1]), int(x.max()) + 1, int(y.max()) + 1)
    return found


def n_log_n(most: int) -> np.ndarray:
    """n log n for n = 0 .. most.

    Examples
    --------
    >>> n_log_n(2).round(2)
    array([0.  , 0.  , 1.39])
    """
    n = np.arange(most + 1, dtype=np.float64)
    return n * np.log(np.maximum(n, 1))


@kernel
def pair_information(found, x, y, table, x_bins, y_bins):
    """Fill `found` (a, b) for levels x (a, n) and y (b, n), from 0 on."""
    samples = x.shape[1]
    joint = np.zeros(x_bins * y_bins, np.int32)
    x_sums, y_sums = np.empty(x.shape[0]), np.empty(y.shape[0])
    for sums, levels, bins in ((x_sums, x, x_bins), (y_sums, y, y_bins)):
        for k in range(levels.shape[0]):
            joint[:bins] = 0
            for i in range(samples):
                joint[levels[k, i]] += 1
            sums[k] = table_sum(joint, bins, table)
    for k in range(x.shape[0]):
        for m in range(y.shape[0]):
            joint[:] = 0
            for i in range(samples):
                joint[np.int64(x[k, i]) * y_bins + y[m, i]] += 1
            both = table_sum(joint, joint.size, table)
            information = (table[samples] + both - x_sums[k] - y_sums[m]) / samples
            found[k, m] = information if information > ROUNDING else 0.0


@kernel
def table_sum(counts, bins, table):
    """Sum of n log n over the first bins."""
    total = 0.0
    for k in range(bins):
        total += table[counts[k]]
    return total
