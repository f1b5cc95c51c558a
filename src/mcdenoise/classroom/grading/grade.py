"""`mcdenoise classroom grade`: a folder of notebooks in, one table and a page of feedback a student out.

Assertions stay in this process. From a submission only the answer to each exercise is taken (see `extract`), its source is
run in a child process (see `sandbox`), and the tests call it through `remote.RemoteImplementation` (see `marking`). Points
are the sum of the points of the tests that pass. Nothing that a submission holds or does changes another's grade.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, wait
from pathlib import Path

from mcdenoise.classroom.checking.check import find_tests
from mcdenoise.classroom.checking.exercise import ExerciseTests
from mcdenoise.classroom.checking.finding import Finding
from mcdenoise.classroom.grading.feedback import write_feedback
from mcdenoise.classroom.grading.marking import exercises_of, failed, grade_files, grade_submission, read_tests
from mcdenoise.classroom.grading.results import Grade, ResultStore, summary, write_csv
from mcdenoise.classroom.grading.sandbox import SANDBOXES, SENTENCES, Limits, choose_sandbox
from mcdenoise.classroom.grading.submissions import Submission, find_submissions
from mcdenoise.study.machine import usable_cores

__all__ = ["add_arguments", "grade_folder", "grade_submission", "run_grade"]

AT_ONCE = 64  # submissions handed to the executor before the first is back


def grade_folder(
    folder: Path,
    tests: Path,
    *,
    executor: Executor | None = None,
    workers: int | None = None,
    limits: Limits | None = None,
    results: Path | None = None,
    fresh: bool = False,
) -> list[Grade]:
    """Grade a folder: one file a student (.ipynb or .py), or one folder a student.

    Parameters
    ----------
    folder : of submissions.
    tests : exercise tests, a file or a folder.
    executor : anything with the interface of `concurrent.futures.Executor`. Submissions and tests travel as bytes, so
        that the workers need nothing but this package. The default is a pool of threads: the work is done in child
        processes, threads only wait for them, and nothing has to be pickled or imported again. A class too large for one
        machine goes to a Dask cluster (each worker says in its grades whether it had a sandbox)::

            from distributed import Client
            with Client("tcp://scheduler:8786") as client:
                grades = grade_folder(folder, tests, executor=client.get_executor())
    workers : threads of the default pool (default: the processor's cores that this process may use).
    limits : what each submission may use.
    results : folder for one JSON file a submission: a run that was interrupted goes on from there. A grade is used again
        only if submission, tests, limits, sandbox and version are the same. None keeps nothing.
    fresh : grade all again.

    Returns
    -------
    list of Grade
        Sorted by student. A submission that cannot be read, and one that the grader itself failed on, has 0 points and
        says so in `problem`; the latter is not kept in `results`.

    Raises
    ------
    ValueError
        If there is no submission or no test, or a sandbox is wanted that does not work.
    """
    limits = limits or Limits()
    submissions, contents = find_submissions(folder), read_tests(tests)
    exercises = exercises_of(contents)
    facts = {**limits.facts(), "sandbox": choose_sandbox(limits.sandbox)}
    store = ResultStore(results, facts, contents) if results is not None else None
    own = ThreadPoolExecutor(workers or usable_cores()) if executor is None else None
    try:
        jobs = _jobs(submissions, contents, limits, executor or own, store, fresh)
        grades = {grade.student: grade for grade in _finished(jobs, store, exercises, len(submissions))}
    finally:
        if own is not None:
            own.shutdown(cancel_futures=True)
    return [grades[one.student] for one in submissions]


def _jobs(
    submissions: list[Submission],
    tests: Mapping[str, bytes],
    limits: Limits,
    executor: Executor,
    store: ResultStore | None,
    fresh: bool,
) -> Iterator[tuple[str, dict[str, bytes], Grade | Future]]:
    """Give student, contents, and the stored grade or a future of it; submissions are read as they are asked for."""
    for one in submissions:
        contents, problem = one.read()
        known = store.load(one.student, contents) if store is not None and not fresh and not problem else None
        yield (
            one.student,
            contents,
            known or executor.submit(grade_files, one.student, contents, tests, limits, problem),
        )


def _finished(
    jobs: Iterator, store: ResultStore | None, exercises: Mapping[str, ExerciseTests], count: int
) -> Iterator[Grade]:
    """Give grades as they come, with a progress bar; only some submissions are in memory at a time."""
    from tqdm import tqdm

    waiting: dict[Future, tuple[str, dict[str, bytes]]] = {}
    with tqdm(total=count, desc="grading", unit="student", disable=None) as bar:
        more = True
        while more or waiting:
            while more and len(waiting) < AT_ONCE:
                student, contents, job = next(jobs, (None, None, None))
                more = job is not None
                if isinstance(job, Grade):
                    bar.update()
                    yield job
                elif more:
                    waiting[job] = student, contents
            for job in wait(waiting, return_when=FIRST_COMPLETED).done:
                bar.update()
                yield _result(job, *waiting.pop(job), store, exercises)


def _result(
    job: Future,
    student: str,
    contents: dict[str, bytes],
    store: ResultStore | None,
    exercises: Mapping[str, ExerciseTests],
) -> Grade:
    """Return and store the grade of a finished job; where the grader itself failed, a grade that says so."""
    try:
        grade = job.result()
    except Exception as error:
        words = f"the grader failed, this is not the student's fault; run it again ({type(error).__name__}: {error})."
        return Grade(student, tuple(failed(one, Finding(words)) for one in exercises.values()), "", words)
    if store is not None and not grade.problem:
        store.save(grade, contents)
    return grade


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `mcdenoise classroom grade`."""
    add = parser.add_argument
    add(
        "submissions",
        type=Path,
        metavar="SUBMISSIONS",
        help="folder: one notebook (.ipynb, .py) or one folder a student",
    )
    add(
        "--out",
        type=Path,
        required=True,
        metavar="CSV",
        help="table of grades; CSV.results/ beside it keeps each grade",
    )
    add("--feedback", type=Path, metavar="DIR", help="write one page of feedback a student there")
    add("--tests", type=Path, metavar="PATH", help="exercise tests, a folder or one file (default tests/exercises)")
    add("--workers", type=int, metavar="N", help="submissions at the same time (default: the number of cores)")
    add("--timeout", type=float, default=Limits.seconds, metavar="S", help="seconds of one call (default %(default)g)")
    add("--total", type=float, default=Limits.total_seconds, metavar="S", help="of a submission (default %(default)g)")
    add("--memory", type=int, default=Limits.memory_mb, metavar="MB", help="memory of a process (default %(default)d)")
    add("--sandbox", choices=SANDBOXES, default=Limits.sandbox, help="default auto: bubblewrap where it works")
    add("--fresh", action="store_true", help="grade all again, also what is known from an earlier run")


def run_grade(options: argparse.Namespace) -> int:
    """Run `mcdenoise classroom grade`: write the table and the feedback, and say how it was done.

    Raises
    ------
    ValueError
        If a folder, a limit or the sandbox is not as needed.
    """
    if options.workers is not None and options.workers < 1:
        raise ValueError(f"--workers must be 1 or more, got {options.workers}.")
    if not options.out.absolute().parent.is_dir() or options.out.is_dir():
        raise ValueError(f"--out must name a file in a folder that exists, got {options.out}.")
    limits = Limits(options.timeout, options.total, options.memory, options.sandbox)
    grades = grade_folder(
        options.submissions,
        options.tests or find_tests(Path.cwd()),
        workers=options.workers,
        limits=limits,
        results=options.out.with_name(f"{options.out.name}.results"),
        fresh=options.fresh,
    )
    write_csv(grades, options.out)
    print(summary(grades))
    print(SENTENCES[choose_sandbox(limits.sandbox)])
    print(f"Table: {options.out}")
    if options.feedback is not None:
        write_feedback(grades, options.feedback)
        print(f"Feedback: {options.feedback}, one page a student")
    return 0
