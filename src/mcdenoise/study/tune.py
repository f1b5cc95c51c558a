"""Bandwidths by search: with the reference (a generous opponent), or by halves of the samples, without it.

python -m mcdenoise.study.tune dof glossy [--spp 8] [--size 128] [--methods cross_bilateral nlm]
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from tqdm import tqdm

from mcdenoise.filters import gaussian
from mcdenoise.metrics import relmse
from mcdenoise.render import capture, render_reference
from mcdenoise.samples import SampleBuffer, pixel_mean
from mcdenoise.samples.gate import check_names
from mcdenoise.study.arguments import OneLineParser
from mcdenoise.study.methods import METHODS, Method, Parameters

Error = Callable[[Parameters], float]
STEP = np.sqrt(2.0)  # a bandwidth is refined by this factor, up and down
SCALE_SIGMA = 1.5  # pixels: blur of the image that errors are relative to; narrower, and one bright sample decides


@dataclass(frozen=True)
class Tuned:
    """What a search found.

    Attributes
    ----------
    parameters : of the method, the best found
    error : what was minimised: relMSE with a reference, else the expected excess of `halves_error`
    tried : number of parameters tried
    """

    parameters: Parameters
    error: float
    tried: int


def reference_error(method: Method, samples: SampleBuffer, reference: np.ndarray) -> Error:
    """Return the function from parameters to relMSE.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(np.ones((4, 4, 1, 3)), corner + 0.5)
    >>> reference_error(METHODS["gaussian"], flat, np.ones((4, 4, 3)))({"sigma_space": 1.0}) < 1e-12
    True
    """
    prepared = method.prepare(samples)
    return lambda parameters: relmse(method.apply(prepared, **parameters), reference)


def error_scale(mean: np.ndarray) -> np.ndarray:
    """Return what squared errors are divided by where there is no reference: a blurred image stands in for it in relMSE.

    Examples
    --------
    >>> error_scale(np.ones((2, 2, 3), np.float32)).round(2)[0, 0]
    array([1.01, 1.01, 1.01], dtype=float32)
    """
    return gaussian(mean, sigma_space=SCALE_SIGMA) ** 2 + 0.01


def halves_error(method: Method, samples: SampleBuffer) -> Error:
    """Return the function from parameters to the error that two independent halves of the samples let us expect.

    For halves A and B, E |F(A) - B|^2 = E |F(A) - truth|^2 + variance of B, and the last term is the same for all parameters.
    What is left is squared bias plus the variance of F(A). All samples together have half that variance, and |F(A) - F(B)|^2
    is twice it on average, so a quarter of it is taken off (exact for a linear filter). Errors are relative as in relMSE,
    with a blurred A in the denominator: it must not know B. At least 2 spp are needed.

    Examples
    --------
    >>> corner = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(np.ones((4, 4, 2, 3)), np.repeat(corner + 0.5, 2, axis=2))
    >>> abs(halves_error(METHODS["gaussian"], flat)({"sigma_space": 1.0})) < 1e-12
    True
    """
    half = samples.spp // 2
    halves = samples.subset(0, half), samples.subset(half, 2 * half)
    means = [pixel_mean(one.radiance) for one in halves]
    scales = [error_scale(mean) for mean in means]
    prepared = [method.prepare(one) for one in halves]

    def error(parameters: Parameters) -> float:
        filtered = [method.apply(one, **parameters) for one in prepared]
        excess = (filtered[0] - filtered[1]) ** 2 / 4
        pairs = zip(filtered, reversed(means), scales, strict=True)
        return sum(float((((image - other) ** 2 - excess) / scale).mean()) for image, other, scale in pairs)

    return error


def choose_parameters(method: Method, samples: SampleBuffer) -> Parameters:
    """Choose one of the method's candidates by halves of the samples; the middle one with 1 spp, which has no halves.

    Where there is one candidate, nothing is run.

    Returns
    -------
    One of ``method.candidates(samples)``.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(1 + 0.5 * rng.random((16, 16, 4, 3)), np.repeat(corner + 0.5, 4, axis=2))
    >>> choose_parameters(METHODS["gaussian"], flat)
    {'sigma_space': 2.8}
    """
    candidates = method.candidates(samples)
    if samples.spp < 2 or len(candidates) == 1:
        return candidates[len(candidates) // 2]
    return min(_shown(candidates, method), key=halves_error(method, samples))


def tune(method: Method, samples: SampleBuffer, reference: np.ndarray | None = None) -> Tuned:
    """Search the best parameters of a method for one scene: the best candidate, then one bandwidth after the other.

    Each number of the best candidate is multiplied or divided by sqrt(2) as long as that helps, until none helps, within
    the range that the candidates span: beyond it an error that hardly changes would be followed for ever.

    Parameters
    ----------
    method : from `METHODS`.
    samples : of the scene.
    reference : (h, w, 3), to minimise relMSE; None: by halves of the samples, as `choose_parameters` does.

    Returns
    -------
    Tuned

    Raises
    ------
    ValueError
        Without reference and with 1 spp; for a reference of another size.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> corner = np.stack(np.meshgrid(np.arange(16), np.arange(16)), axis=-1)[:, :, np.newaxis]
    >>> flat = SampleBuffer.from_arrays(1 + 0.5 * rng.random((16, 16, 4, 3)), np.repeat(corner + 0.5, 4, axis=2))
    >>> tune(METHODS["gaussian"], flat, np.full((16, 16, 3), 1.25)).parameters
    {'sigma_space': 2.8}
    """
    if reference is None and samples.spp < 2:
        raise ValueError("Tuning without a reference needs at least 2 spp, two halves; got 1. Pass a reference.")
    error = halves_error(method, samples) if reference is None else reference_error(method, samples, reference)
    tried: dict[str, float] = {}

    def once(parameters: Parameters) -> float:
        key = repr(parameters)
        if key not in tried:
            tried[key] = error(parameters)
        return tried[key]

    candidates = method.candidates(samples)
    best = min(_shown(candidates, method), key=once)
    improved = True
    while improved:
        improved = False
        for place in _dials(best):
            span = [value for value in (_value(one, place) for one in candidates) if np.isfinite(value)]
            for factor in (STEP, 1 / STEP):
                while min(span) <= _value(other := _scaled(best, place, factor), place) <= max(span):
                    if once(other) >= once(best):
                        break
                    best, improved = other, True
    return Tuned(best, once(best), len(tried))


def _dials(parameters: Parameters, above: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Where the finite floating point numbers stand, also in dicts: whole numbers such as radii are left alone."""
    found = []
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            found += _dials(value, (*above, name))
        elif isinstance(value, float) and np.isfinite(value):
            found.append((*above, name))
    return found


def _value(parameters: Parameters, place: tuple[str, ...]) -> float:
    """The number that stands in a place."""
    for name in place:
        parameters = parameters[name]
    return float(parameters)


def _scaled(parameters: Parameters, place: tuple[str, ...], factor: float) -> Parameters:
    """A copy with one number multiplied."""
    name, *rest = place
    value = parameters[name]
    changed = _scaled(value, tuple(rest), factor) if rest else float(value * factor)
    return {**parameters, name: changed}


def _shown(candidates: Sequence[Parameters], method: Method) -> Sequence[Parameters]:
    """The candidates behind a progress bar."""
    return tqdm(candidates, f"bandwidths of {method.label}", disable=None, leave=False)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code (2, with one line on stderr, for what could not be done)."""
    parser = OneLineParser(prog="python -m mcdenoise.study.tune", description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+", metavar="SCENE", help="toy scenes, or Mitsuba XML files")
    parser.add_argument("--spp", type=int, default=8, help="samples per pixel (default 8)")
    parser.add_argument("--size", type=int, default=128, help="height and width in pixels (default 128)")
    parser.add_argument("--methods", nargs="+", metavar="NAME", help="methods to tune (default: all)")
    parser.add_argument("--reference-spp", type=int, default=1024, help="of the reference (default 1024)")
    try:
        options = parser.parse_args(arguments)
        names = check_names(METHODS if options.methods is None else options.methods, list(METHODS), "methods")
        for scene in options.scenes:
            print_tuned(scene, names, options)
    except SystemExit as leaving:
        return int(leaving.code or 0)
    except (ValueError, OSError) as error:
        print(f"tune: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


def print_tuned(scene: str, names: Sequence[str], options: argparse.Namespace) -> None:
    """Tune methods on one scene both ways, and print relMSE and parameters."""
    samples = capture(scene, options.size, options.size, options.spp, seed=0)
    reference = render_reference(scene, options.size, options.size, spp=options.reference_spp, seed=0)
    print(f"{scene}, {options.size} x {options.size}, {options.spp} spp: relMSE")
    print(f"  {'unfiltered':28} {relmse(pixel_mean(samples.radiance), reference):.5f}")
    for name in names:
        method = METHODS[name]
        error = reference_error(method, samples, reference)
        for way, found in (("by halves", tune(method, samples)), ("by reference", tune(method, samples, reference))):
            print(f"  {name:28} {error(found.parameters):.5f}  {way}, {found.tried} tried: {_words(found.parameters)}")


def _words(parameters: Parameters) -> str:
    """Parameters in one line, three digits each."""
    parts = [] if parameters else ["nothing to choose"]
    for name, value in parameters.items():
        text = "{" + _words(value) + "}" if isinstance(value, Mapping) else f"{value:.3g}"
        parts.append(f"{name} {text}")
    return ", ".join(parts)


if __name__ == "__main__":
    sys.exit(main())
