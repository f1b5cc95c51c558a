"""Images without samples: the reference, and plain Monte Carlo at any spp as the honest rival of every filter."""

import hashlib
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import numpy as np
from tqdm import tqdm

from mcdenoise.render.capture import trace_all
from mcdenoise.render.motion import slice_time, spread_slices
from mcdenoise.render.scene import ReadyScene, check_size, derived_seed, load_scene
from mcdenoise.render.variants import use_variant
from mcdenoise.samples.storage import cache_folder, write_beside

CHUNK = 2**21  # samples rendered at once: bounds memory, and lets the progress bar move
STREAM_IMAGE, STREAM_REFERENCE = 3, 4
Part = tuple[np.ndarray, np.ndarray]  # of a chunk: sum of finite samples (h, w, 3), their number (h, w, 1)


def render_image(
    scene: object,
    width: int = 128,
    height: int = 128,
    spp: int = 8,
    seed: int = 0,
    *,
    variant: str = "auto",
    progress: bool | None = None,
) -> np.ndarray:
    """Render plain Monte Carlo at `spp` samples per pixel with Mitsuba's path integrator and the box filter.

    The scene, its path length and its moving objects are those of :func:`capture`, and so are expectation and variance; the
    random numbers are others at any seed. Where something moves, samples have independent times, which takes as long as
    capturing them without features.

    Parameters
    ----------
    scene, width, height, spp, seed, variant, progress : as for :func:`capture`

    Returns
    -------
    (height, width, 3) float32, scene-linear RGB, unclamped. A pixel is the mean over those chunks of samples in which it
    came out finite (a chunk is at most 2**21 samples of the whole image).

    Raises
    ------
    ValueError
        For an unknown scene, a scene that Mitsuba refuses, a bad size, or a pixel that is never finite.

    Examples
    --------
    >>> render_image("dof", width=8, height=6, spp=4, variant="scalar_rgb").shape
    (6, 8, 3)
    """
    width, height, spp, seed = check_size(width, height, spp, seed)
    with use_variant(variant):
        ready = load_scene(scene, width, height)
        render = _rendered if ready.poser is None else _traced
        return _mean(render(ready, (height, width), spp, seed, STREAM_IMAGE, progress), ready)


def render_reference(
    scene: object,
    width: int = 128,
    height: int = 128,
    spp: int = 1024,
    seed: int = 0,
    *,
    variant: str = "auto",
    progress: bool | None = None,
) -> np.ndarray:
    """Render the reference of `scene`, or load it if it was rendered before.

    Its random numbers are independent of those of :func:`capture` and :func:`render_image` at the same seed, so its error
    is not correlated with theirs. It is kept in ``references`` in the cache folder (``MCDENOISE_CACHE``, else the user's
    cache), named after everything it depends on: the content of the scene, size, spp, seed, variant and versions. A file
    that can not be read is rendered again; a folder that can not be written to does no harm.

    Parameters
    ----------
    scene, width, height, spp, seed, variant, progress : as for :func:`capture`

    Returns
    -------
    (height, width, 3) float32, scene-linear RGB, unclamped

    Raises
    ------
    ValueError
        As :func:`render_image`.

    Examples
    --------
    >>> render_reference("dof", width=8, height=6, spp=4, variant="scalar_rgb").shape
    (6, 8, 3)
    """
    width, height, spp, seed = check_size(width, height, spp, seed)
    with use_variant(variant) as chosen:
        ready = load_scene(scene, width, height)
        shelf = _shelf(ready, chosen, width, height, spp, seed)
        image = _load(shelf, (height, width, 3))
        if image is None:
            image = _mean(_rendered(ready, (height, width), spp, seed, STREAM_REFERENCE, progress), ready)
            _keep(shelf, image)
    return image


def _rendered(
    ready: ReadyScene, size: tuple[int, int], spp: int, seed: int, stream: int, progress: bool | None
) -> Iterator[Part]:
    """Render with Mitsuba, chunk by chunk: a pixel of a chunk is finite or not as a whole."""
    import mitsuba as mi

    bar = tqdm(
        total=spp,
        desc=f"render {ready.label}",
        unit=" spp",
        delay=2,
        disable=None if progress is None else not progress,
    )
    with bar:
        for index, count in enumerate(_chunks(ready, size, spp, seed, stream)):
            one_seed = derived_seed(seed, stream, index + 1)
            image = np.array(mi.render(ready.scene, integrator=ready.integrator, spp=count, seed=one_seed))
            finite = np.isfinite(image).all(axis=2, keepdims=True)
            yield np.where(finite, image, 0).astype(np.float64) * count, finite * count
            bar.update(count)


def _traced(
    ready: ReadyScene, size: tuple[int, int], spp: int, seed: int, stream: int, progress: bool | None
) -> Iterator[Part]:
    """Trace samples with independent times, chunk by chunk."""
    most = _most_spp(size)
    for index, first in enumerate(range(0, spp, most)):
        count = min(most, spp - first)
        one_seed = derived_seed(seed, stream, index + 1)
        radiance = trace_all(ready, ["radiance"], (*size, count), one_seed, progress)["radiance"]
        samples = radiance.reshape(*size, count, 3)
        finite = np.isfinite(samples).all(axis=3, keepdims=True)
        yield np.where(finite, samples, 0).sum(axis=2, dtype=np.float64), finite.sum(axis=2)


def _mean(parts: Iterator[Part], ready: ReadyScene) -> np.ndarray:
    """Divide the sum of finite samples by their number, which must not be 0 anywhere."""
    total, norm = next(parts)
    for part, count in parts:
        total, norm = total + part, norm + count
    if not norm.all():
        raise ValueError(
            f"{int((norm == 0).sum())} pixels of {ready.label} are never finite. Check its lights and BSDFs."
        )
    return (total / norm).astype(np.float32)


def _most_spp(size: tuple[int, int]) -> int:
    """Return the samples per pixel of a whole chunk."""
    return max(1, CHUNK // (size[0] * size[1]))


def _chunks(ready: ReadyScene, size: tuple[int, int], spp: int, seed: int, stream: int) -> Iterator[int]:
    """Give the samples per pixel of each chunk, after posing the scene for it."""
    most = _most_spp(size)
    counts = [spp]
    if ready.poser is not None:
        counts = spread_slices(np.random.default_rng([seed, stream]), spp).tolist()
    for index, count in enumerate(counts):
        if ready.poser is not None and count:
            ready.poser.at(slice_time(index))
        yield from [most] * (count // most) + [count % most] * (count % most > 0)


def _shelf(ready: ReadyScene, variant: str, width: int, height: int, spp: int, seed: int) -> Path | None:
    """Return the file of a reference; None if the scene can not be told from others by its content."""
    if ready.fingerprint is None:
        return None
    versions = [version(package) for package in ("mitsuba", "drjit", "mcdenoise")]
    key = repr((ready.fingerprint, str(ready.integrator), width, height, spp, seed, variant, versions))
    return cache_folder() / "references" / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.npy"


def _load(shelf: Path | None, shape: tuple[int, int, int]) -> np.ndarray | None:
    """Return a stored reference, or None if there is none that is whole."""
    if shelf is None or not shelf.is_file():
        return None
    try:
        image = np.load(shelf, allow_pickle=False)
    except (OSError, ValueError, EOFError):
        return None
    is_whole = image.shape == shape and image.dtype == np.float32 and np.isfinite(image).all()
    return image if is_whole else None


def _keep(shelf: Path | None, image: np.ndarray) -> None:
    """Store a reference; a folder that can not be written to is no error."""
    if shelf is None:
        return
    try:
        shelf.parent.mkdir(parents=True, exist_ok=True)
        with write_beside(shelf) as temporary:
            np.save(temporary, image)
    except OSError as error:
        print(f"The reference could not be kept in {shelf.parent}: {error.strerror}.", file=sys.stderr)
