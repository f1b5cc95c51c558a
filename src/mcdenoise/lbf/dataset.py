"""Chapter 09: training data. Random scenes, rendered once, at several spp; kept on disk, because rendering is half the time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from mcdenoise.lbf.primary import GROUPS, KEPT_BY_GROUP, Primary, primary_features
from mcdenoise.render import capture, choose_variant, render_reference
from mcdenoise.render.scenes.random_scene import random_scene
from mcdenoise.samples.gate import check_count
from mcdenoise.samples.storage import cache_folder, open_npz, write_npz

SPP = (4, 8, 16, 32, 64)
DIRECTED = ("world_position", "shading_normal")
FORMAT = "mcdenoise-lbf-data-1"
# How often a group stays: every scene has the first three, while second hits and visibility are rarer.
KEEP = dict(zip(GROUPS, (1.0, 1.0, 1.0, 0.5, 0.5), strict=True))


@dataclass(frozen=True)
class DataConfig:
    """Which scenes a model learns from.

    Attributes
    ----------
    scenes, validation : how many to learn from, and how many more to stop by; never the same
    size : height and width, pixels
    spp : samples per pixel; all of one scene are subsets of one capture, disjoint where the largest has room for all
        others
    reference_spp : of the references
    first : seed of the first scene

    Examples
    --------
    >>> DataConfig(scenes=2, validation=1).seeds
    ((0, 1), (2,))
    """

    scenes: int = 100
    validation: int = 20
    size: int = 96
    spp: tuple[int, ...] = SPP
    reference_spp: int = 256
    first: int = 0

    def __post_init__(self) -> None:
        for name, least in (("scenes", 1), ("validation", 1), ("size", 16), ("reference_spp", 1), ("first", 0)):
            check_count(getattr(self, name), name, least=least)
        spp = tuple(check_count(spp, "spp") for spp in self.spp)
        if not spp or sorted(set(spp)) != list(spp):
            raise ValueError(f"spp must be different numbers in ascending order, got {self.spp}.")
        object.__setattr__(self, "spp", spp)

    @property
    def seeds(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Seeds of the training scenes, and of the validation scenes."""
        middle = self.first + self.scenes
        return tuple(range(self.first, middle)), tuple(range(middle, middle + self.validation))


@dataclass(frozen=True, eq=False)
class SceneData:
    """One scene: its features at each spp, and its reference (h, w, 3)."""

    name: str
    primaries: tuple[Primary, ...]
    reference: np.ndarray


def subsets(spp: Sequence[int]) -> list[tuple[int, int]]:
    """First sample and end of each subset of max(spp) samples: one after the other where they fit, else from 0.

    Examples
    --------
    >>> subsets((4, 8, 16))
    [(0, 4), (4, 12), (0, 16)]
    """
    found, start = [], 0
    for count in spp:
        if start + count > max(spp):
            start = 0
        found.append((start, start + count))
        start += count
    return found


def scene_data(seed: int, config: DataConfig) -> SceneData:
    """Render one random scene."""
    scene = random_scene(seed)
    samples = capture(scene, config.size, config.size, max(config.spp), seed, nonfinite="zero", progress=False)
    reference = render_reference(scene, config.size, config.size, config.reference_spp, seed, progress=False)
    primaries = tuple(primary_features(samples.subset(*part)) for part in subsets(config.spp))
    return SceneData(scene.name, primaries, reference)


def load_data(config: DataConfig, folder: Path | None = None) -> tuple[list[SceneData], list[SceneData]]:
    """Training and validation scenes, from `folder`, or rendered and kept there.

    Parameters
    ----------
    folder : default: one in the cache folder, named after everything that the data depend on.

    Raises
    ------
    ValueError
        If `folder` holds scenes that were rendered with another size or other spp.
    """
    folder = folder or _shelf(config)
    folder.mkdir(parents=True, exist_ok=True)
    seeds = config.seeds
    bar = tqdm([*seeds[0], *seeds[1]], desc="training scenes", unit="scene", delay=2, disable=None, leave=False)
    found = [_load_or_render(seed, config, folder / f"scene_{seed}.npz") for seed in bar]
    return found[: len(seeds[0])], found[len(seeds[0]) :]


def _shelf(config: DataConfig) -> Path:
    """The folder for these data."""
    depends = [asdict(config) | {"scenes": 0, "validation": 0, "first": 0}, FORMAT, choose_variant()]
    depends += [version(package) for package in ("mitsuba", "drjit", "mcdenoise")]
    return cache_folder() / f"lbf-data-{hashlib.sha256(json.dumps(depends).encode()).hexdigest()[:16]}"


def _load_or_render(seed: int, config: DataConfig, path: Path) -> SceneData:
    """One scene; a file that is not whole is made again."""
    if path.is_file():
        try:
            found, settings = _load(path)
        except ValueError:
            path.unlink()
        else:
            if settings != _settings(config):
                raise ValueError(
                    f"{path} was rendered with {settings}, needed is {_settings(config)}. Name another folder, or delete "
                    f"this one."
                )
            return found
    found = scene_data(seed, config)
    _save(found, config, path)
    return found


def _settings(config: DataConfig) -> dict[str, Any]:
    """What a scene's data depend on besides its seed, as JSON holds it."""
    return {"size": config.size, "spp": list(config.spp), "reference_spp": config.reference_spp}


def _save(data: SceneData, config: DataConfig, path: Path) -> None:
    """Write one scene."""
    arrays = {"reference": data.reference}
    for primary in data.primaries:
        arrays |= {f"{primary.spp}/{name}": getattr(primary, name) for name in ("colour", "colour_variance")}
        for kind in KEPT_BY_GROUP:
            arrays |= {f"{primary.spp}/{kind}/{group}": one for group, one in getattr(primary, kind).items()}
    about = {"format": FORMAT, "name": data.name, "groups": data.primaries[0].groups, "settings": _settings(config)}
    write_npz(path, "Training data are", about, arrays)


def _load(path: Path) -> tuple[SceneData, dict[str, Any]]:
    """Read one scene, and the settings that it was rendered with."""
    with open_npz(path, "training data", "It is rendered again.") as stored:
        about = json.loads(str(stored["about"]))
        primaries = []
        for spp in about["settings"]["spp"]:
            kinds = [{g: stored[f"{spp}/{kind}/{g}"] for g in about["groups"]} for kind in KEPT_BY_GROUP]
            primaries.append(Primary(stored[f"{spp}/colour"], stored[f"{spp}/colour_variance"], *kinds, spp=spp))
        return SceneData(about["name"], tuple(primaries), stored["reference"]), about["settings"]


def drop_groups(primary: Primary, groups: Sequence[str], rng: np.random.Generator) -> Primary:
    """The features of a scene that lacks some of `groups`, drawn at random: so a model learns to do without them."""
    kept = [g for g in groups if g in primary.groups and rng.random() < KEEP[g]]
    return primary.select(kept)


def flip_axes(primary: Primary, rng: np.random.Generator) -> Primary:
    """The same scene with some axes of the world turned round.

    Which way an axis points is a convention, and no distance knows it; but the network sees means of positions and
    normals, and would learn by heart where things stand in the training scenes.
    """
    signs = np.where(rng.random(3) < 0.5, -1, 1).astype(np.float32)
    kinds = {kind: dict(getattr(primary, kind)) for kind in ("raw", "features")}
    for arrays in kinds.values():
        arrays |= {group: arrays[group] * signs for group in DIRECTED if group in arrays}
    return replace(primary, **kinds)
