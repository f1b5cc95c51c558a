"""Every method on two buffers, written to one file: run by `stability` in processes with other numbers of threads.

python -m mcdenoise.study.stability_threads FILE.npz SIZE DRAWS
"""

from __future__ import annotations

import sys

import numpy as np

from mcdenoise.study.methods import METHODS
from mcdenoise.study.stability_run import run_method
from mcdenoise.study.stability_settings import Settings
from mcdenoise.study.stability_special import THREADS, small_room


def main() -> None:
    """Write the images, named after method and level."""
    path, size, draws = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
    settings, images = Settings(size=size, draws=draws), {}
    for label, decades in zip(THREADS, (0, 8), strict=True):
        samples = small_room(decades, size)
        images |= {f"{name} {label}": run_method(name, samples, settings) for name in METHODS}
    np.savez(path, **images)


if __name__ == "__main__":
    main()
