"""The hostile set: submissions as files, what each must get, and a command that prints times and scores of the whole set.

    python tests/hostile/harness.py [bwrap | fence | wall]

"wall" is bubblewrap alone, without the courtesy fence inside: it shows that the wall holds by itself.
"""

import json
import os
import socket
import sys
import tempfile
import tomllib
from contextlib import contextmanager, suppress
from pathlib import Path

from mcdenoise.classroom.grading import marking
from mcdenoise.classroom.grading.grade import grade_folder
from mcdenoise.classroom.grading.sandbox import Limits

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
TESTS = HERE / "blur_tests.py"
POINTS = 8
BURST = 64
LIMITS = Limits(seconds=2.0, total_seconds=30.0, memory_mb=1024)


def expected():
    """Name -> points, hint (a part of a message), and in which sandboxes other than all."""
    return tomllib.loads((HERE / "expected.toml").read_text(encoding="utf-8"))


def sources(outside, port, burst=BURST):
    """Name -> source of the submissions, with the places of this machine filled in."""
    texts = {path.name.removesuffix(".py.txt"): path.read_text(encoding="utf-8") for path in HERE.glob("submissions/*")}
    places = {"@REPOSITORY@": REPOSITORY, "@OUTSIDE@": outside, "@PORT@": port, "@BURST@": burst}
    for name, text in texts.items():
        text = text.replace("@RIGHT@", texts["right"])
        for mark, place in places.items():
            text = text.replace(mark, str(place))
        texts[name] = text
    return texts


def write_submissions(folder, texts):
    """Write the submissions as scripts, and those that are no Python: notebooks, whole and broken, folders."""
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(f"# %%\n{text}" if text else "", encoding="utf-8")
    cells = [{"cell_type": "code", "source": ["%matplotlib inline\n", texts["right"]], "metadata": {}, "outputs": []}]
    whole = json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5})
    (folder / "right_notebook.ipynb").write_text(whole)
    (folder / "broken_notebook.ipynb").write_text(whole[:-40])
    (folder / "not_utf8.py").write_bytes(b"blur = '\xff\xfe'")
    (folder / "a_folder" / "week 2").mkdir(parents=True)
    (folder / "a_folder" / "week 2" / "notes.txt").write_text("no notebook")
    (folder / "right_in_folder").mkdir()
    (folder / "right_in_folder" / "work.py").write_text(texts["right"])
    with (folder / "too_large.ipynb").open("wb") as file:
        file.truncate(200 << 20)  # sparse: takes no room
    (folder / "a_link.py").symlink_to(folder / "right.py")


@contextmanager
def listener():
    """A server on 127.0.0.1 that answers nobody; gives its port and a function that counts who came."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(0.1)

        def visitors():
            count = 0
            try:
                while True:
                    server.accept()[0].close()
                    count += 1
            except TimeoutError:
                return count

        yield server.getsockname()[1], visitors


def leftovers():
    """Processes of this grader's children that still run."""
    mark = f"MCDENOISE_GRADING={os.getpid()}-".encode()
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if mark in (place / "environ").read_bytes():
                found.append((place / "cmdline").read_bytes())
    return found


def grade_set(folder, sandbox, tests=TESTS, **options):
    """Grade a folder in "bwrap", "fence", or "wall"; returns student -> Grade."""
    chosen = marking.choose_sandbox
    limits = Limits(**{**LIMITS.facts(), "sandbox": "bwrap" if sandbox == "wall" else sandbox})
    if sandbox == "wall":
        marking.choose_sandbox = lambda wanted: "wall"
    try:
        return {grade.student: grade for grade in grade_folder(folder, tests, limits=limits, **options)}
    finally:
        marking.choose_sandbox = chosen


def messages(grade):
    """All that a student is told."""
    return [grade.problem, *(outcome.message for one in grade.exercises for outcome in one.outcomes)]


def table(grades):
    """Lines of name, points, seconds, first message."""
    lines = [f"{'submission':28} {'points':>6} {'s':>5}  first finding"]
    for name, grade in grades.items():
        said = next((one for one in messages(grade) if one), "")
        lines.append(f"{name:28} {grade.total:6g} {grade.seconds:5.1f}  {said[:100]}")
    return "\n".join(lines)


def main(sandbox="bwrap"):
    """Grade the whole set and print the table."""
    with tempfile.TemporaryDirectory() as place, listener() as (port, visitors):
        submissions, outside = Path(place) / "submissions", Path(place) / "outside"
        submissions.mkdir()
        outside.mkdir()
        write_submissions(submissions, sources(outside, port))
        grades = grade_set(submissions, sandbox)
        print(table(grades))
        seconds = sum(grade.seconds for grade in grades.values())
        print(f"{len(grades)} submissions, {seconds:.1f} s one after the other, sandbox {sandbox}, ", end="")
        print(f"visitors {visitors()}, files outside {sorted(path.name for path in outside.iterdir())}")


if __name__ == "__main__":
    main(*sys.argv[1:])
