"""Runs on this machine, several worker processes at a time."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from multiprocessing.connection import wait

from guideway.lab.child import Child, Item, owner
from guideway.lab.experiment import Run
from guideway.lab.journal import Record

SHORT = 0.2
"""Runs shorter than this are queued ahead, so that a worker never waits, s."""

AHEAD = 8
"""How many."""


Lot = tuple[str, str]
"""Runs of one owner on one world."""


class Todo:
    """Runs that wait, by owner and world: a worker that has made a world goes on with it, and is not shared by planners of users."""

    def __init__(self, runs: Sequence[Run], digest: str) -> None:
        self._lots: dict[Lot, deque[Item]] = {}
        for run in runs:
            self._lots.setdefault(_lot(run), deque()).append((run, digest))
        self._taken: dict[int, Lot] = {}
        """What the workers are at."""

    def __bool__(self) -> bool:
        """Is anything left?"""
        return bool(self._lots)

    def owner(self, worker: int) -> str:
        """Whose run is the next for a worker."""
        return self._next(worker)[0]

    def take(self, worker: int) -> Item:
        """The next run for a worker."""
        lot = self._taken[worker] = self._next(worker)
        item = self._lots[lot].popleft()
        if not self._lots[lot]:
            del self._lots[lot]
        return item

    def _next(self, worker: int) -> Lot:
        """Its lot; else of the same owner, else of any, one that nobody is at, else that with most runs left."""
        last = self._taken.get(worker, ("", ""))
        if last in self._lots:
            return last
        lots = [lot for lot in self._lots if lot[0] == last[0]] or list(self._lots)
        free = (lot for lot in lots if lot not in self._taken.values())
        return next(free, None) or max(lots, key=lambda lot: len(self._lots[lot]))

    def back(self, items: Sequence[Item]) -> None:
        """Gives back what a worker left."""
        for item in reversed(items):
            self._lots.setdefault(_lot(item[0]), deque()).appendleft(item)


def _lot(run: Run) -> Lot:
    return owner(run), run.world["name"]


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
                        self._fill(number, todo)
                yield from _next(children, todo)
        finally:
            for number in [number for number, child in children.items() if child.waiting]:
                children.pop(number).close()

    def _fill(self, number: int, todo: Todo) -> None:
        """Puts runs in; a worker that has run a user's planner is replaced before it gets anything else."""
        child = self._children[number]
        ahead = AHEAD if child.ready and child.last < SHORT and not child.big else 1
        while todo and len(child.waiting) < ahead:
            if child.owner not in ("", todo.owner(number)):
                if child.waiting:
                    return
                child.close()
                child = self._children[number] = Child(child.kind)
            child.put(todo.take(number))

    def close(self) -> None:
        """Ends the processes."""
        for number in list(self._children):
            self._children.pop(number).close()


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
