"""EXR in and out, through Mitsuba's Bitmap: the way to and from other renderers."""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from mcdenoise.render.variants import use_variant
from mcdenoise.samples.gate import check_image, check_nonfinite, check_same_size
from mcdenoise.samples.storage import write_beside

_CHANNELS = {1: "Y", 2: "YA", 3: "RGB", 4: "RGBA"}


def write_exr(path: str | os.PathLike, image: object) -> None:
    """Write an image, or several as named layers of one file, as OpenEXR in float32.

    Parameters
    ----------
    path : str or path, ending in ``.exr``. Whole or not at all: written beside and renamed.
    image : (h, w) or (h, w, c), or a mapping layer name -> such an array, all of one size. The layer ``""`` is the one
        that viewers show first.

    Raises
    ------
    ValueError
        For another suffix, a missing folder, a bad image (NaN included), layers of different sizes or a bad layer name.

    See Also
    --------
    read_exr : reads the image or one layer back.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_exr(Path(folder) / "two.exr", {"": np.ones((2, 3, 3)), "albedo": np.zeros((2, 3, 3))})
    ...     read_exr(Path(folder) / "two.exr", layer="albedo").max()
    np.float32(0.0)
    """
    path = _exr_path(path)
    layers = image if isinstance(image, Mapping) else {"": image}
    if not layers:
        raise ValueError("image must name at least one layer, got an empty mapping.")
    names, planes = [], []
    for layer, values in layers.items():
        if not isinstance(layer, str) or not (layer == "" or layer.isidentifier()):
            raise ValueError(f"A layer's name must be a plain word or '', got {layer!r}.")
        array = np.atleast_3d(check_image(values, layer or "image").astype(np.float32))
        planes.append(check_same_size(array, layer or "image", planes[0] if planes else array, "the first layer"))
        channels = _CHANNELS.get(array.shape[2]) or [f"{k:04}" for k in range(array.shape[2])]
        names += [f"{layer}.{channel}".lstrip(".") for channel in channels]
    with write_beside(path) as temporary, use_variant("scalar_rgb"):
        import mitsuba as mi

        block = np.ascontiguousarray(np.concatenate(planes, axis=2))
        mi.Bitmap(block, pixel_format=mi.Bitmap.PixelFormat.MultiChannel, channel_names=names).write(str(temporary))


def read_exr(path: str | os.PathLike, layer: str | None = None, nonfinite: str = "raise") -> np.ndarray:
    """Read an OpenEXR image, or one layer of it, as float32.

    Parameters
    ----------
    path : str or path
    layer : name of the layer; default: the only one, or the unnamed one
    nonfinite : ``"raise"`` or ``"zero"``, what to do about NaN and infinite pixels

    Returns
    -------
    (h, w) for one channel, else (h, w, c) float32; channels R, G, B, A in this order, others by name

    Raises
    ------
    ValueError
        If there is no such file or layer, if it is no image Mitsuba can read, or for NaN with ``"raise"``.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_exr(Path(folder) / "grey.exr", np.full((2, 3), 0.5))
    ...     read_exr(Path(folder) / "grey.exr").shape
    (2, 3)
    """
    path = _exr_path(path)
    if not path.is_file():
        raise ValueError(f"An EXR file is read from disk, but there is no file {path}.")
    with use_variant("scalar_rgb"):
        import mitsuba as mi

        try:
            bitmap = mi.Bitmap(str(path))
        except RuntimeError as error:
            raise ValueError(f"{path} can not be read as an image: {error}") from error
        names = [channel.name for channel in bitmap.struct_()]
        block = np.atleast_3d(np.array(bitmap)).astype(np.float32)
    layers = sorted({name.rpartition(".")[0] for name in names})
    chosen = layers[0] if layer is None and len(layers) == 1 else layer or ""
    if chosen not in layers:
        raise ValueError(f"{path} has no layer {layer!r}; choose one with layer=: {', '.join(layers)}.")
    columns = [k for k, name in enumerate(names) if name.rpartition(".")[0] == chosen]
    columns.sort(key=lambda k: _channel_order(names[k].rpartition(".")[2]))
    image = block[:, :, columns] if len(columns) > 1 else block[:, :, columns[0]]
    return check_nonfinite(image, path.name, nonfinite)


def _channel_order(channel: str) -> tuple[int, str]:
    """Sort R, G, B before A, and other channels by their names (X, Y, Z; 0000, 0001)."""
    return "RGB".find(channel) if channel in "RGB" else 3 + (channel == "A"), channel


def _exr_path(path: str | os.PathLike) -> Path:
    """Return `path` if its name ends in .exr."""
    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise ValueError(f"An OpenEXR file must be named *.exr, got {path.name!r}.")
    return path
