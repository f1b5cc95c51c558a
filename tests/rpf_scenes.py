"""Small sample buffers whose truth is known, for the tests of random parameter filtering."""

import numpy as np

import mcdenoise as mcd


def buffer(size=12, spp=8, radiance=None, features=None, random_params=("lens_u", "lens_v"), seed=0, width=None):
    """Samples of a white plane, unless told otherwise; what is given may be a function of (x, y, params)."""
    rng = np.random.default_rng(seed)
    shape = (size, size if width is None else width, spp)
    corner = np.stack(np.meshgrid(np.arange(shape[1]), np.arange(shape[0])), axis=-1)[:, :, np.newaxis]
    position = corner + rng.random((*shape, 2), dtype=np.float32) * 0.999
    params = {name: rng.random(shape) for name in random_params}
    x, y = position[..., 0], position[..., 1]

    def field(value):
        value = np.asarray(value(x, y, params) if callable(value) else value, np.float32)
        return np.broadcast_to(value[..., np.newaxis] if value.ndim == 3 else value, (*shape, 3)).copy()

    return mcd.SampleBuffer.from_arrays(
        radiance=field(1.0 if radiance is None else radiance),
        screen_position=position,
        random_params=params,
        features={name: field(value) for name, value in (features or {}).items()},
    )


def edge(x, y, params):
    """A step in the middle of 12 pixels, known by its place on the screen."""
    return 0.2 + 0.6 * (x >= 6)


def blurred(x, y, params):
    """Half of the lens sees 0.2, the other half 0.8: the truth is 0.5 everywhere."""
    return 0.2 + 0.6 * (params["lens_u"] >= 0.5)
