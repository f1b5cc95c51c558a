"""Pages on paper: a PDF of each built page, printed by Chromium from a local server that lives only as long."""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Iterator, Sequence
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from tqdm import tqdm

from mcdenoise.samples.storage import write_beside

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PAGE_SECONDS = 120


def find_chromium() -> str | None:
    """Return the path of Chromium or Chrome, None where neither is on the path.

    Examples
    --------
    >>> find_chromium() is None or Path(find_chromium()).exists()
    True
    """
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def print_pages(site: Path, pages: Sequence[str], folder: Path, chromium: str) -> list[Path]:
    """Print pages of a built site as PDF.

    Parameters
    ----------
    site : the folder of the built site.
    pages : names of pages in it, without .html.
    folder : for the PDFs, one a page; made if missing.
    chromium : the browser, as `find_chromium` returns it.

    Raises
    ------
    ValueError
        If the browser fails, writes nothing, or takes longer than 120 seconds for a page.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    with serve(site) as address:
        for page in tqdm(pages, desc="PDF", unit="page", disable=None):
            written.append(folder / f"{page}.pdf")
            with write_beside(written[-1]) as temporary:
                _print(chromium, f"{address}/{page}.html", temporary)
    return written


@contextlib.contextmanager
def serve(folder: Path) -> Iterator[str]:
    """Serve a folder to this machine alone, on a free port, while the block runs; gives the address."""
    with ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Quiet, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()


class _Quiet(SimpleHTTPRequestHandler):
    """A handler that does not report each request."""

    def log_message(self, format: str, *arguments: object) -> None:
        pass


def _print(chromium: str, address: str, target: Path) -> None:
    """Print one page."""
    try:
        done = run_chromium(chromium, "--no-pdf-header-footer", f"--print-to-pdf={target}", address)
    except subprocess.TimeoutExpired:
        raise ValueError(f"{chromium} took longer than {PAGE_SECONDS} seconds to print {address}.") from None
    if done.returncode != 0 or not target.read_bytes().startswith(b"%PDF"):
        raise ValueError(f"{chromium} could not print {address}: {done.stderr.strip()[-500:] or 'no PDF came out'}.")


def run_chromium(chromium: str, *arguments: str) -> subprocess.CompletedProcess:
    """Run the browser without a window; scripts of the page get 20 seconds of its own (virtual) time.

    Raises
    ------
    subprocess.TimeoutExpired
        After 120 seconds.
    """
    command = [chromium, "--headless", "--disable-gpu", "--virtual-time-budget=20000"]
    command += ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []  # root cannot have one
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command += [f"--user-data-dir={profile}", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=PAGE_SECONDS, check=False)
