"""capture: render a scene and keep every sample with its random parameters and features (chapter 01)."""

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from tqdm import tqdm

from mcdenoise.render.motion import TIME_SLICES, draw_slices, slice_time
from mcdenoise.render.scene import ReadyScene, check_size, derived_seed, load_scene
from mcdenoise.render.trace_scalar import trace_scalar
from mcdenoise.render.trace_wavefront import trace_wavefront
from mcdenoise.render.variants import use_variant
from mcdenoise.samples import SampleBuffer
from mcdenoise.samples.gate import NONFINITE_CHOICES, check_choice, check_names
from mcdenoise.samples.layout import CHANNELS, FEATURES, RANDOM_PARAMS

WAVEFRONT = 2**21  # samples traced at once: some 300 MB of arrays
STREAM_SAMPLES, STREAM_TIME = 1, 2


def capture(
    scene: object,
    width: int = 128,
    height: int = 128,
    spp: int = 8,
    seed: int = 0,
    *,
    variant: str = "auto",
    random_params: Sequence[str] | None = None,
    features: Sequence[str] | None = None,
    nonfinite: str = "raise",
    progress: bool | None = None,
) -> SampleBuffer:
    """Render `scene` and return all samples: x_i = {p, r, f, c} (Sen & Darabi 2012, section 3).

    The radiance is that of Mitsuba's own path integrator with the box filter. The random parameters are the numbers
    that it used at the first hit: the sampler's state is copied just before the integrator draws from it.

    Parameters
    ----------
    scene : str, path, mapping or ToyScene
        A name of ``scene_names()``, the path of a Mitsuba XML file, a Mitsuba dict, or a ToyScene of your own. The first
        camera of a dict or file is used with our film; its own path integrator if it has one, else one of depth 8.
    width, height : int, pixels
    spp : int, samples per pixel, independent of each other
    seed : int, in [0, 2**32)
    variant : ``"auto"``, ``"scalar_rgb"`` or ``"llvm_ad_rgb"``, see :func:`choose_variant`. The Mitsuba variant that was
        set before the call is set again after it. With LLVM the mean of the samples equals ``mitsuba.render`` with the same
        `seed` and `spp` bit for bit, as long as nothing moves and there are at most 2**21 samples. The two variants use
        other random numbers.
    random_params, features : list of names, default: those of the toy scene. For other scenes the default is the random
        parameters that the path integrator uses there, and the features that vary over the captured image.
    nonfinite : ``"raise"`` or ``"zero"``, what to do about NaN and infinite samples
    progress : bool, default: a bar on stderr when that is a terminal and the work takes more than 2 s

    Returns
    -------
    SampleBuffer
        Features are those of the first hit: `world_position` (scene units; 0 where the ray missed), `shading_normal` (unit, in
        world space, as Mitsuba gives it: outwards even when seen from inside; 0 on a miss), `albedo` (diffuse reflectance
        in [0, 1]; 0 on a miss and on surfaces without a diffuse lobe, such as metal). With `_2`: the same at the hit of a
        ray scattered in the direction that the BSDF sample `bsdf_u, bsdf_v` gives. `visibility` is 1 where the point
        `light_u, light_v` on the lights sends light to the first hit, unblocked. `time` is the share of the open shutter. A
        random number that a sample had no use for (the ray missed) is still a uniform random number.

    Raises
    ------
    ValueError
        For an unknown scene or name, a scene that Mitsuba refuses, a bad size, or NaN in the samples with ``"raise"``.

    Examples
    --------
    >>> samples = capture("dof", width=8, height=6, spp=2, variant="scalar_rgb")
    >>> samples.radiance.shape, "lens_u" in samples.random_param_names
    ((6, 8, 2, 3), True)
    """
    width, height, spp, seed = check_size(width, height, spp, seed)
    check_choice(nonfinite, NONFINITE_CHOICES, "nonfinite")
    with use_variant(variant) as chosen:
        ready = load_scene(scene, width, height)
        asked = _asked(ready, random_params, features)
        names = ["radiance", "screen_position", "hit", *asked]
        traced = trace_all(ready, names, (height, width, spp), seed, progress)
        about = _provenance(ready, chosen, width, height, spp, seed)
    traced = {name: values.reshape(height, width, spp, -1) for name, values in traced.items()}
    if features is None and ready.toy is None:
        asked = [name for name in asked if name not in FEATURES or np.ptp(traced[name], axis=(0, 1, 2)).any()]
    return SampleBuffer.from_arrays(
        radiance=traced["radiance"],
        screen_position=traced["screen_position"],
        random_params={name: traced[name] for name in asked if name in RANDOM_PARAMS},
        features={name: traced[name] for name in asked if name in FEATURES},
        hit=traced["hit"][..., 0] > 0,
        provenance=about,
        nonfinite=nonfinite,
    )


def _asked(ready: ReadyScene, random_params: object, features: object) -> list[str]:
    """Return the names to record: what the caller asked for, else what the scene says, else what it can use."""
    if random_params is None:
        random_params = ready.toy.random_params if ready.toy else ready.random_params
    if features is None:
        second = "bsdf_u" in ready.random_params
        features = ready.toy.features if ready.toy else [n for n in FEATURES if second or not n.endswith("_2")]
    return [
        *check_names(random_params, ready.random_params, "random_params"),
        *check_names(features, tuple(FEATURES), "features"),
    ]


def trace_all(
    ready: ReadyScene, names: Sequence[str], size: tuple[int, int, int], seed: int, progress: bool | None
) -> dict[str, np.ndarray]:
    """Trace every sample, pass by pass, and return name -> (h * w * spp, channels) float32 in pixel order.

    Where something moves, the times of the samples are independent of each other.
    """
    import mitsuba as mi

    trace = trace_scalar if mi.variant() == "scalar_rgb" else trace_wavefront
    height, width, spp = size
    result = {name: np.empty((height * width * spp, CHANNELS[name]), np.float32) for name in names}
    rows = 1 if trace is trace_scalar else max(1, WAVEFRONT // (width * spp))
    bar = tqdm(
        total=height * width * spp,
        desc=f"capture {ready.label}",
        unit=" samples",
        unit_scale=True,
        delay=2,
        disable=None if progress is None else not progress,
    )
    with bar:
        for index, (time, samples) in enumerate(_passes(ready, size, rows, seed)):
            one_seed = seed if index == 0 else derived_seed(seed, STREAM_SAMPLES, index)
            traced = trace(ready, names, samples // spp, width, one_seed)
            for name in names:
                result[name][samples] = time if name == "time" else traced[name]
            bar.update(len(samples))
    return result


def _passes(ready: ReadyScene, size: tuple[int, int, int], rows: int, seed: int) -> Iterator[tuple[float, Any]]:
    """Cut the samples into passes and pose the scene for each; give (time, indices of the samples in pixel order)."""
    height, width, spp = size
    if ready.poser is None:
        for first in range(0, height * width * spp, rows * width * spp):
            yield 0.5, np.arange(first, min(first + rows * width * spp, height * width * spp))
        return
    slices = draw_slices(np.random.default_rng([seed, STREAM_TIME]), height * width * spp)
    order = np.argsort(slices, kind="stable")
    ends = np.searchsorted(slices[order], np.arange(TIME_SLICES + 1))
    for k in range(TIME_SLICES):
        if ends[k] < ends[k + 1]:
            ready.poser.at(slice_time(k))
            yield slice_time(k), order[ends[k] : ends[k + 1]]


def _provenance(ready: ReadyScene, variant: str, width: int, height: int, spp: int, seed: int) -> dict[str, Any]:
    """Say where the samples come from."""
    return {
        "scene": ready.label,
        "idea": ready.toy.idea if ready.toy else "",
        "width": width,
        "height": height,
        "spp": spp,
        "seed": seed,
        "variant": variant,
        **{package: version(package) for package in ("mitsuba", "drjit", "mcdenoise")},
    }
