"""From what the user gives (a name, a ToyScene, a Mitsuba dict, an XML file) to a scene that is ready to render."""

import contextlib
import hashlib
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mcdenoise.render.motion import Poser
from mcdenoise.render.scenes import SCENES
from mcdenoise.render.toyscene import ToyScene
from mcdenoise.samples.gate import check_count
from mcdenoise.samples.layout import RANDOM_PARAMS

FOREIGN_DEPTH = 8  # path length where a foreign scene does not bring its own path integrator
CAMERAS = ("perspective", "thinlens", "orthographic")
FILMS = ("hdrfilm", "specfilm")


def scene_names() -> tuple[str, ...]:
    """Return the names of the toy scenes.

    Examples
    --------
    >>> "dof" in scene_names()
    True
    """
    return tuple(SCENES)


@dataclass(frozen=True)
class ReadyScene:
    """A loaded scene and what was found out about it; valid while the variant that loaded it is set.

    Attributes
    ----------
    label : str                   what to call it in messages and in the provenance
    scene, integrator             Mitsuba's objects
    toy : ToyScene or None        what the scene says about itself
    random_params : tuple of str  those that Mitsuba's path integrator really uses here, at the first hit
    poser : Poser or None         puts the moving objects where they are at a time; None if nothing moves
    fingerprint : str or None     equal for equal scenes, whatever the size; None if that cannot be told
    """

    label: str
    scene: Any
    integrator: Any
    toy: ToyScene | None
    random_params: tuple[str, ...]
    poser: Poser | None
    fingerprint: str | None


def load_scene(scene: object, width: int, height: int) -> ReadyScene:
    """Load `scene` with a box-filtered film of `width` x `height` pixels under the variant that is set.

    Raises
    ------
    ValueError
        For an unknown name, a missing file, or a scene that Mitsuba refuses (with Mitsuba's words).
    """
    if isinstance(scene, ToyScene):
        return _load_toy(scene, width, height)
    if isinstance(scene, Mapping):
        return _load_dict(scene, width, height)
    if not isinstance(scene, (str, os.PathLike)):
        raise ValueError(
            f"scene must be a name ({', '.join(SCENES)}), a Mitsuba dict or the path of a Mitsuba XML file, got a "
            f"{type(scene).__name__}."
        )
    if scene in SCENES:
        return _load_toy(SCENES[scene], width, height)
    if isinstance(scene, str) and not scene.lower().endswith(".xml"):
        raise ValueError(f"scene has no {scene!r}; there is: {', '.join(SCENES)}; or pass a dict or an .xml file.")
    return _load_xml(Path(scene), width, height)


def check_size(width: object, height: object, spp: object, seed: object) -> tuple[int, int, int, int]:
    """Return what every render takes, as ints: at least 1 each; `seed` at least 0 and below 2**32.

    Raises
    ------
    ValueError
        For anything else.
    """
    width, height, spp = check_count(width, "width"), check_count(height, "height"), check_count(spp, "spp")
    seed = check_count(seed, "seed", least=0)
    if seed >= 2**32:
        raise ValueError(f"seed must be below 2**32, got {seed}.")
    return width, height, spp, seed


def derived_seed(seed: int, stream: int, index: int) -> int:
    """Return a seed for one pass of one purpose; different purposes and passes do not share random numbers."""
    return int(np.random.SeedSequence([seed, stream, index]).generate_state(1)[0])


def _film(width: int, height: int) -> dict[str, Any]:
    """The film of every render: a pixel's samples are its own."""
    return {
        "type": "hdrfilm",
        "width": int(width),
        "height": int(height),
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }


def _load_toy(toy: ToyScene, width: int, height: int) -> ReadyScene:
    """Load a toy scene with the path length it asks for."""
    description = dict(toy.build()) | {"integrator": {"type": "path", "max_depth": toy.max_depth}}
    ready = _load_dict(description, width, height)
    if not toy.motion:
        return replace(ready, label=toy.name, toy=toy)
    return replace(
        ready,
        label=toy.name,
        toy=toy,
        random_params=tuple(name for name in RANDOM_PARAMS if name == "time" or name in ready.random_params),
        poser=Poser(ready.scene, toy.motion),
        fingerprint=ready.fingerprint and _digest(ready.fingerprint, repr(sorted(toy.motion.items()))),
    )


def _load_dict(description: Mapping[str, Any], width: int, height: int) -> ReadyScene:
    """Load a Mitsuba dict; its first camera gets our film, other cameras are left out."""
    import mitsuba as mi

    cameras = [k for k, v in description.items() if isinstance(v, Mapping) and v.get("type") in CAMERAS]
    if description.get("type") != "scene" or not cameras:
        raise ValueError(
            f"scene must be a Mitsuba dict with 'type': 'scene' and a camera given as a dict of type "
            f"{' or '.join(CAMERAS)}, got the keys {', '.join(map(str, description)) or 'none'}."
        )
    ours = {k: v for k, v in description.items() if k not in cameras[1:]}
    camera = {k: v for k, v in ours[cameras[0]].items() if not (isinstance(v, Mapping) and v.get("type") in FILMS)}
    ours[cameras[0]] = camera | {"film": _film(width, height)}
    try:
        scene = mi.load_dict(ours)
    except Exception as error:
        raise ValueError(f"Mitsuba refuses the scene dict: {error}") from error
    return _describe(scene, "dict", _fingerprint(description))


def _load_xml(path: Path, width: int, height: int) -> ReadyScene:
    """Load a Mitsuba XML file; its first <sensor> gets our film, other sensors are left out."""
    import mitsuba as mi

    if not path.is_file():
        raise ValueError(
            f"scene names the file {path}, but there is none. Check the path; toy scenes: {', '.join(SCENES)}."
        )
    try:
        root = ET.fromstring(path.read_bytes())
        cameras = root.findall("sensor")
        if not cameras:
            raise ValueError("it has no <sensor> at its top level")
        for other in cameras[1:]:
            root.remove(other)
        for film in cameras[0].findall("film"):
            cameras[0].remove(film)
        cameras[0].append(_as_xml("film", "", _film(width, height)))
        with _files_beside(path):
            scene = mi.load_string(ET.tostring(root, encoding="unicode"))
    except Exception as error:
        raise ValueError(f"Mitsuba refuses the scene file {path}: {error}") from error
    parts = [path.read_bytes()]
    parts += [_file_bytes(path.parent / e.get("value", e.get("filename", ""))) for e in root.iter() if _names_file(e)]
    return _describe(scene, str(path), _digest(*parts))


def _as_xml(tag: str, name: str, entry: object) -> ET.Element:
    """Write one entry of a Mitsuba dict as XML."""
    if isinstance(entry, dict):
        element = ET.Element(tag, {"type": entry["type"]} | ({"name": name} if name else {}))
        element.extend(_as_xml(k if k == "rfilter" else "", k, v) for k, v in entry.items() if k != "type")
        return element
    kind = "integer" if isinstance(entry, int) else "string"
    return ET.Element(kind, {"name": name, "value": str(entry)})


def _describe(scene: Any, label: str, fingerprint: str | None) -> ReadyScene:
    """Find out which random numbers Mitsuba's path integrator uses at the first hit of `scene`."""
    import mitsuba as mi

    integrator = scene.integrator()
    if not str(integrator).startswith("PathIntegrator"):
        integrator = mi.load_dict({"type": "path", "max_depth": FOREIGN_DEPTH})
    depth = int(re.search(r"max_depth = (\d+)", str(integrator))[1])
    delta = [bool(int(e.flags()) & int(mi.EmitterFlags.Delta)) for e in scene.emitters()]
    used = {
        "lens": bool(scene.sensors()[0].needs_aperture_sample()),
        "light": depth > 1 and (len(delta) > 1 or not all(delta)),  # with several lights the number also picks one
        "bsdf": depth > 2 or (depth > 1 and not all(delta)),
    }
    names = tuple(f"{kind}_{axis}" for kind, is_used in used.items() if is_used for axis in "uv")
    return ReadyScene(label, scene, integrator, None, names, None, fingerprint)


def _fingerprint(description: Mapping[str, Any]) -> str | None:
    """Return a digest of a scene dict and of the files that it names; None if it holds an object that hides its state."""
    parts: list[bytes | str] = []
    for key, value in description.items():
        parts.append(str(key))
        if isinstance(value, Mapping):
            part = _fingerprint(value)
        elif key == "filename":
            part = _file_bytes(Path(str(value)))
        elif value is None or isinstance(value, (str, bool, int, float)):
            part = repr(value)
        else:
            part = _array_bytes(value)
        if part is None:
            return None
        parts.append(part)
    return _digest(*parts)


def _array_bytes(value: object) -> bytes | None:
    """Return the numbers in a list, array, transform, bitmap or tensor as bytes; None for anything else."""
    numbers = np.asarray(getattr(value, "matrix", value))
    return None if numbers.dtype.kind not in "buif" else str(numbers.shape).encode() + numbers.tobytes()


@contextlib.contextmanager
def _files_beside(path: Path) -> Iterator[None]:
    """Let Mitsuba find the files that an XML file names relative to itself."""
    import mitsuba as mi

    before = mi.file_resolver()
    ours = mi.FileResolver()
    for folder in (path.absolute().parent, *(before[k] for k in range(len(before)))):
        ours.append(str(folder))
    mi.set_file_resolver(ours)
    try:
        yield
    finally:
        mi.set_file_resolver(before)


def _names_file(element: ET.Element) -> bool:
    """Return whether an XML element names a file that the scene is made of."""
    return element.tag == "include" or (element.tag == "string" and element.get("name") == "filename")


def _file_bytes(path: Path) -> bytes:
    """Return what is in a file, or its name if it cannot be read."""
    try:
        return path.read_bytes()
    except OSError:
        return str(path).encode()


def _digest(*parts: bytes | str) -> str:
    """Return one short digest of all parts, each kept apart."""
    together = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        together.update(len(data).to_bytes(8, "little") + data)
    return together.hexdigest()[:24]
