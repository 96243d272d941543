"""Runs on this machine, several worker processes at a time."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from multiprocessing.connection import wait

from guideway.lab.child import Child, Item
from guideway.lab.experiment import Run
from guideway.lab.journal import Record

SHORT = 0.2
"""Runs shorter than this are queued ahead, so that a worker never waits, s."""

AHEAD = 8
"""How many."""


class Todo:
    """Runs that wait, by world: a worker that has made a world goes on with it."""

    def __init__(self, runs: Sequence[Run], digest: str) -> None:
        self._worlds: dict[str, deque[Item]] = {}
        for run in runs:
            self._worlds.setdefault(run.world["name"], deque()).append((run, digest))
        self._taken: dict[int, str] = {}
        """What worlds the workers are at."""

    def __bool__(self) -> bool:
        """Is anything left?"""
        return bool(self._worlds)

    def take(self, worker: int) -> Item:
        """The next run for a worker: of its world, else of one that nobody is at, else of that with most runs left."""
        world = self._taken.get(worker, "")
        if world not in self._worlds:
            free = (name for name in self._worlds if name not in self._taken.values())
            world = next(free, None) or max(self._worlds, key=lambda name: len(self._worlds[name]))
            self._taken[worker] = world
        item = self._worlds[world].popleft()
        if not self._worlds[world]:
            del self._worlds[world]
        return item

    def back(self, items: Sequence[Item]) -> None:
        """Gives back what a worker left."""
        for item in reversed(items):
            self._worlds.setdefault(item[0].world["name"], deque()).appendleft(item)


class Local:
    """Worker processes on this machine; they stay between experiments until they are closed."""

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._children: dict[int, Child] = {}

    def records(self, runs: Sequence[Run], digest: str) -> Generator[Record, None, None]:
        """The records of all runs, as they come. A worker that dies, or is killed for its time, costs the run that it was at."""
        todo, children = Todo(runs, digest), self._children
        try:
            while todo or any(child.waiting for child in children.values()):
                for number in range(self._workers):
                    if todo and number not in children:
                        children[number] = Child(runs[0].kind)
                    if number in children:
                        _fill(children[number], todo, number)
                yield from _next(children, todo)
        finally:
            for number in [number for number, child in children.items() if child.waiting]:
                children.pop(number).close()

    def close(self) -> None:
        """Ends the processes."""
        for number in list(self._children):
            self._children.pop(number).close()


def _fill(child: Child, todo: Todo, number: int) -> None:
    ahead = AHEAD if child.ready and child.last < SHORT and not child.big else 1
    while todo and len(child.waiting) < ahead:
        child.put(todo.take(number))


def _next(children: dict[int, Child], todo: Todo) -> Iterator[Record]:
    """Waits for something to happen and yields the records of it; workers that have ended are taken out."""
    rest = min(child.deadline for child in children.values()) - time.monotonic()
    wait([child.connection for child in children.values()], max(0.0, min(rest, 1.0)))
    for number, child in list(children.items()):
        try:
            found = child.take()
        except EOFError:
            pass
        else:
            yield from found
            if found or not child.overdue():
                continue
        record = child.failed()
        todo.back(child.waiting)
        child.close()
        del children[number]
        if record is not None:
            yield record
