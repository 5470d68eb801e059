"""Tasks on all cores, with results kept by content: a second call does nothing anew."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol, TypeVar, get_type_hints

import cv2

from topomap.bench.kept import from_plain, to_plain

R = TypeVar("R", covariant=True)
T = TypeVar("T")
DECIDING = (
    "core/*.py",
    "vision/**/*.py",
    "datasets/**/*.py",
    "bench/**/*.py",
    "experiments/*.py",
    "navigation/**/*.py",
    "evaluation/statistics.py",
)
"""The source files whose change makes kept results void."""


class Task(Protocol[R]):
    """Something to compute whose `key` says all that decides the result; picklable."""

    @property
    def key(self) -> str: ...

    def perform(self) -> R: ...


class Store:
    """Results as JSON in files named by the digest of their task's key and of the code; folder None keeps nothing."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self.hits = 0

    def get(self, task: Task[T]) -> T | None:
        """Return the kept result of a task, or None; a damaged file counts as none."""
        if self._folder is None:
            return None
        try:
            found: T = from_plain(_kind(task), json.loads(self._path(task.key, self._folder).read_bytes()))
        except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return None
        self.hits += 1
        return found

    def put(self, key: str, result: object) -> None:
        """Keep a result; whole or not at all."""
        if self._folder is None:
            return
        path = self._path(key, self._folder)
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(json.dumps(to_plain(result)).encode())
        Path(file.name).replace(path)

    def forget(self, key: str) -> None:
        """Take a kept result away."""
        if self._folder is not None:
            self._path(key, self._folder).unlink(missing_ok=True)

    def _path(self, key: str, folder: Path) -> Path:
        name = hashlib.sha256(f"{version('topomap')} {code_digest()} {key}".encode()).hexdigest()
        return folder / name[:2] / f"{name}.json"


def _kind(task: Task[T]) -> Any:  # Any: a type as a value
    """Return what a task's `perform` says that it returns."""
    return get_type_hints(type(task).perform)["return"]


def default_folder() -> Path:
    """Return where results are kept unless told otherwise: TOPOMAP_CACHE or the user's cache folder."""
    named = os.environ.get("TOPOMAP_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "topomap" / "bench"


@cache
def code_digest() -> str:
    """Return a digest of the code that decides the results."""
    return digest_files(Path(__file__).parents[1], DECIDING)


def digest_files(root: Path, patterns: Sequence[str]) -> str:
    """Return a digest of the files under root that match, by name and content."""
    digest = hashlib.sha256()
    for path in sorted({path for pattern in patterns for path in root.glob(pattern)}):
        digest.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


class Workers:
    """A number of processes, or this one alone; results never depend on how many."""

    def __init__(self, store: Store, pool: ProcessPoolExecutor | None) -> None:
        self._store = store
        self._pool = pool

    def run(
        self, tasks: Sequence[Task[T]], advance: Callable[[], None], take: Callable[[T], None] | None = None
    ) -> list[T]:
        """Return the results in the order of the tasks; `advance` is called after each that is done, `take` with it."""
        results: dict[int, T] = {}

        def done(i: int, result: T) -> None:
            results[i] = result
            if take is not None:
                take(result)
            advance()

        for i, task in enumerate(tasks):
            kept = self._store.get(task)
            if kept is not None:
                done(i, kept)
        missing = [i for i in range(len(tasks)) if i not in results]
        for i, result in self._performed(tasks, missing):
            self._store.put(tasks[i].key, result)
            done(i, result)
        return [results[i] for i in range(len(tasks))]

    def _performed(self, tasks: Sequence[Task[T]], missing: list[int]) -> Iterator[tuple[int, T]]:
        if self._pool is None:
            for i in missing:
                yield i, tasks[i].perform()
            return
        waiting = {self._pool.submit(_perform, tasks[i]): i for i in missing}
        for future in as_completed(waiting):
            yield waiting[future], future.result()


@contextmanager
def workers(count: int, store: Store) -> Iterator[Workers]:
    """Yield `count` workers; 1 works in this process."""
    if count <= 1:
        with _one_thread():
            yield Workers(store, None)
        return
    # a forked copy of a process with threads (numba, OpenCV) may hang
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=_single_threaded)
    try:
        yield Workers(store, pool)
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _perform(task: Task[T]) -> T:
    return task.perform()


def _single_threaded() -> None:
    cv2.setNumThreads(1)  # milliseconds are those of one thread


@contextmanager
def _one_thread() -> Iterator[None]:
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)
