"""Samples on disk: one `.npz`, never a pickle, never half a file.

Also the small things that every room that writes needs: `write_beside` (write next to the target, then rename), `write_npz`
and `open_npz`, and `cache_folder` (where things live that can always be made again).
"""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from mcdenoise.samples.buffer import SampleBuffer

FORMAT = "mcdenoise-samples-1"
ARRAYS = ("screen_position", "random_params", "features", "radiance", "hit")


def cache_folder() -> Path:
    """Return the folder for things that can be made again (compiled kernels, references). It need not exist yet.

    `MCDENOISE_CACHE` if that is set, else `mcdenoise` under `XDG_CACHE_HOME`, else under `~/.cache`.

    Examples
    --------
    >>> cache_folder().is_absolute()
    True
    """
    if chosen := os.environ.get("MCDENOISE_CACHE"):
        return Path(chosen).expanduser().absolute()
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home).absolute() / "mcdenoise"


@contextmanager
def write_beside(path: str | os.PathLike) -> Iterator[Path]:
    """Give a temporary file beside `path`, and rename it to `path` when the block ends well; else remove it.

    A reader never meets half a file, and a failure leaves what was there before.

    Raises
    ------
    ValueError
        If `path` is a folder, or the folder that should hold it does not exist.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with write_beside(Path(folder) / "note.txt") as temporary:
    ...         _ = temporary.write_text("whole")
    ...     os.listdir(folder)
    ['note.txt']
    """
    path = Path(path)
    if path.is_dir():
        raise ValueError(f"A file name is needed to write to, got the folder {path}.")
    if not path.parent.is_dir():
        raise ValueError(
            f"The folder {path.parent} must exist before {path.name} can be written there. Create it first."
        )
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_npz(
    path: str | os.PathLike, subject: str, about: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
) -> None:
    """Write named arrays and one JSON text, `about`, to an `.npz` file.

    Parameters
    ----------
    subject : what is stored, for the message: ``"Samples are"``

    Raises
    ------
    ValueError
        If `path` does not end in `.npz` or its folder does not exist.
    """
    path = Path(path)
    if path.suffix != ".npz":
        raise ValueError(f"{subject} stored as .npz, got the name {path.name!r}. Call it {path.stem}.npz.")
    with write_beside(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, about=np.array(json.dumps(about)), **arrays)


@contextmanager
def open_npz(path: str | os.PathLike, what: str, remedy: str) -> Iterator[np.lib.npyio.NpzFile]:
    """Open an `.npz` file without pickle; whatever goes wrong while it is read becomes one sentence.

    Parameters
    ----------
    what : should be in it, for the message: ``"samples written by SampleBuffer.save"``
    remedy : what to do, a sentence

    Raises
    ------
    ValueError
        If there is no such file, it is no whole `.npz`, or what the block asks of it is not in it.

    Examples
    --------
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_npz(Path(folder) / "one.npz", "One is", {}, {"one": np.ones(1)})
    ...     with open_npz(Path(folder) / "one.npz", "a one", "Write it again.") as stored:
    ...         stored["one"]
    array([1.])
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"An .npz file of {what} is needed, but there is no file {path}.")
    try:
        with path.open("rb") as file, np.lib.npyio.NpzFile(file, allow_pickle=False) as stored:
            yield stored
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path} is not a whole file of {what} ({error}). {remedy}") from error


def save_samples(samples: SampleBuffer, path: str | os.PathLike) -> None:
    """Write `samples` to `path`, a `.npz` file of plain arrays (float32; `hit` bool) and one JSON text.

    Raises
    ------
    ValueError
        If `path` does not end in `.npz` or its folder does not exist.

    See Also
    --------
    load_samples : reads the file back, checked.
    """
    about = {
        "format": FORMAT,
        "random_params": {field.name: field.channels for field in samples.layout.random_params},
        "features": {field.name: field.channels for field in samples.layout.features},
        "provenance": dict(samples.provenance),
    }
    write_npz(path, "Samples are", about, {name: getattr(samples, name) for name in ARRAYS})


def load_samples(path: str | os.PathLike, nonfinite: str = "raise") -> SampleBuffer:
    """Read samples that `SampleBuffer.save` wrote; everything passes the gate again.

    Parameters
    ----------
    path : a `.npz` file.
    nonfinite : ``"raise"`` or ``"zero"``, what to do about NaN and infinity.

    Returns
    -------
    SampleBuffer

    Raises
    ------
    ValueError
        If there is no such file, it is no whole `.npz`, holds pickled objects, or its arrays are missing or do not fit.

    Examples
    --------
    >>> buffer = SampleBuffer.from_arrays(radiance=np.ones((1, 1, 4, 3)), screen_position=np.full((1, 1, 4, 2), 0.5))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     buffer.save(Path(folder) / "ones.npz")
    ...     load_samples(Path(folder) / "ones.npz").radiance.shape
    (1, 1, 4, 3)
    """
    with open_npz(path, "samples written by SampleBuffer.save", "Capture or save it again.") as stored:
        arrays = {name: stored[name] for name in (*ARRAYS, "about")}
    return _unpack(arrays, Path(path), nonfinite)


def _unpack(arrays: dict[str, np.ndarray], path: Path, nonfinite: str) -> SampleBuffer:
    """Build the buffer from what the file held."""
    try:
        about = json.loads(str(arrays["about"]))
        found = about["format"]
        widths = {kind: dict(about[kind]) for kind in ("random_params", "features")}
        provenance = dict(about["provenance"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path} lacks a readable description of its samples ({error!r}). Save it again.") from error
    if found != FORMAT:
        raise ValueError(
            f"{path} must have the format {FORMAT}, got {found!r}. Save it with this version of mcdenoise."
        )
    named = {}
    for kind, channels in widths.items():
        block = arrays[kind]
        if block.ndim != 4 or block.shape[-1] != sum(channels.values()):
            raise ValueError(
                f"{path}: {kind} names {sum(channels.values())} numbers a sample, got shape {block.shape}."
            )
        ends = np.cumsum([0, *channels.values()])
        named[kind] = {name: block[..., a:b] for name, a, b in zip(channels, ends[:-1], ends[1:], strict=True)}
    return SampleBuffer.from_arrays(
        radiance=arrays["radiance"],
        screen_position=arrays["screen_position"],
        random_params=named["random_params"],
        features=named["features"],
        hit=arrays["hit"],
        provenance=provenance,
        nonfinite=nonfinite,
    )
