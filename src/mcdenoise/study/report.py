"""What a comparison leaves behind: results.json, two figures, one EXR an image, and report.html, which opens offline."""

from __future__ import annotations

import base64
import html
import json
from importlib import resources
from pathlib import Path
from string import Template
from tempfile import TemporaryFile
from typing import Any

from mcdenoise.render import write_exr
from mcdenoise.samples.storage import write_beside
from mcdenoise.study.charts import error_ceiling, heading, images_figure, save_figure, speed_accuracy_figure
from mcdenoise.study.compare import REPEATS, Comparison, Result
from mcdenoise.study.display import error_colours, png_data_uri, tone_map
from mcdenoise.study.entries import json_ready


def write_all(comparison: Comparison, folder: Path) -> list[Path]:
    """Write every file of the comparison into `folder` (made if missing); each is written beside and renamed.

    Returns
    -------
    The paths written, report.html first.

    Raises
    ------
    ValueError
        As `make_folder`.
    """
    make_folder(folder)
    chart, pictures = folder / "speed_accuracy.png", folder / "images.png"
    save_figure(speed_accuracy_figure(comparison), chart)
    save_figure(images_figure(comparison), pictures)
    written = [folder / "report.html", chart, pictures, folder / "results.json"]
    for name, image in [*((r.name, r.image) for r in comparison.results), ("reference", comparison.reference)]:
        written.append(folder / f"{name}.exr")
        write_exr(written[-1], image)
    _write_text(folder / "results.json", json.dumps(numbers(comparison), indent=2) + "\n")
    _write_text(folder / "report.html", report_page(comparison, chart.read_bytes()))
    return written


def make_folder(folder: Path) -> None:
    """Make `folder` with all above it, and make sure that files can be written there.

    Raises
    ------
    ValueError
        If it is a file, cannot be made, or cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ValueError(
            f"A folder that can be written to is needed for the results, got {folder}: {error}."
        ) from error


def numbers(comparison: Comparison) -> dict[str, Any]:
    """Return everything measured, as JSON can hold it (infinite PSNR as null)."""
    facts = {
        name: value for name, value in vars(comparison).items() if name not in ("results", "reference", "provenance")
    }
    return json_ready(
        {
            **facts,
            "reference_relmse": comparison.reference_relmse,
            "provenance": dict(comparison.provenance),
            "pareto_front": [result.name for result in comparison.front()],
            "results": [result.numbers() for result in comparison.results],
        }
    )


def table(comparison: Comparison) -> str:
    """Return the table for the terminal."""
    width = max(len(result.label) for result in comparison.results) + 2
    lines = [
        f"{'':{width}} {'spp':>5} {'render s':>9} {'filter s':>9} {'total s':>8} {'relMSE':>8} {'PSNR':>6} {'SSIM':>6}"
    ]
    front = {result.name for result in comparison.front()}
    for r in comparison.results:
        mark = " *" if r.name in front else ""
        equal = f"  = time of {'; '.join(r.equal_time_with)}" if r.equal_time_with else ""
        lines.append(
            f"{r.label:{width}} {r.spp:5} {r.render_seconds:9.4f} {r.filter_seconds:9.4f} {r.seconds:8.4f} "
            f"{r.relmse:8.5f} {r.psnr:6.2f} {r.ssim:6.3f}{mark}{equal}"
        )
    return "\n".join([*lines, "", *_notes(comparison)])


def _notes(comparison: Comparison) -> list[str]:
    """What a reader must know to trust the table."""
    compiling = sum(result.compile_seconds for result in comparison.filters)
    choosing = sum(result.choose_seconds for result in comparison.filters)
    return [
        "* on the Pareto front: no other is both faster and more accurate.",
        f"Render seconds: radiance alone, {comparison.render_fixed_seconds:.4f} s + "
        f"{comparison.render_seconds_per_spp:.4f} s a spp. Filter seconds: {_median_words(comparison)}, samples in, image out.",
        f"Not charged: capturing samples and features, {comparison.capture_seconds:.2f} s, slow for being done in Python; "
        f"compiling, {compiling:.1f} s; choosing bandwidths by halves of the samples, {choosing:.1f} s.",
        f"Reference: {comparison.reference_spp} spp; its own noise adds about {comparison.reference_relmse:.5f} to each relMSE.",
    ]


def _median_words(comparison: Comparison) -> str:
    """Of how many runs the filter seconds are the median; slow filters are run fewer times."""
    slow = "; ".join(f"{r.label} {r.repeats}" for r in comparison.filters if r.repeats < REPEATS)
    return f"median of {REPEATS} runs" + (f" (fewer where they are slow: {slow})" if slow else "")


def report_page(comparison: Comparison, chart_png: bytes) -> str:
    """Return report.html: one file with all images inside, no network, no other file."""
    template = Template(resources.files("mcdenoise.study").joinpath("report_template.html").read_text("utf-8"))
    ceiling = error_ceiling(comparison)
    items = [_item(result, comparison, ceiling) for result in comparison.results]
    items.append(
        {
            "label": "reference",
            "spp": str(comparison.reference_spp),
            "image": png_data_uri(tone_map(comparison.reference)),
        }
    )
    blank = dict.fromkeys(("equal", "render", "filter", "total", "relmse", "psnr", "ssim", "error"), "")
    scale = (
        f"Error maps: (x - ref)² / (ref² + 0.01), black 0 to bright {ceiling:.2g}, square root scale, the same for all."
    )
    parameters = {result.label: dict(result.parameters) for result in comparison.filters}
    return template.substitute(
        title=html.escape(f"Denoising {comparison.scene} at {comparison.spp} samples per pixel"),
        heading=html.escape(heading(comparison)),
        notes="<br>".join(html.escape(note) for note in [*_notes(comparison), scale]),
        chart="data:image/png;base64," + base64.b64encode(chart_png).decode("ascii"),
        parameters=html.escape(json.dumps(parameters, indent=2)),
        provenance=html.escape(json.dumps(dict(comparison.provenance), indent=2)),
        data=json.dumps([blank | item for item in items]).replace("<", "\\u003c"),
    )


def _item(result: Result, comparison: Comparison, ceiling: float) -> dict[str, str]:
    """One row and image of the page."""
    star = " *" if result in comparison.front() else ""
    return {
        "label": result.label,
        "equal": f"time of {'; '.join(result.equal_time_with)}" if result.equal_time_with else "",
        "spp": str(result.spp),
        "render": f"{result.render_seconds:.3f}",
        "filter": f"{result.filter_seconds:.4f}" if result.kind == "filter" else "",
        "total": f"{result.seconds:.3f}",
        "relmse": f"{result.relmse:.5f}{star}",
        "psnr": f"{result.psnr:.2f}",
        "ssim": f"{result.ssim:.3f}",
        "image": png_data_uri(tone_map(result.image)),
        "error": png_data_uri(error_colours(comparison.error_map(result), ceiling)),
    }


def _write_text(path: Path, text: str) -> None:
    """Write UTF-8 text beside `path`, then rename."""
    with write_beside(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
