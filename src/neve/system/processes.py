"""Work in several processes, which end with the one that has started them."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait
from typing import Any, TypeVar

from neve.system import stopping

T = TypeVar("T")


def results(
    call: Callable[..., T],
    items: Iterable[Any],
    processes: int,
    prepare: Callable[..., None] | None = None,
    given: tuple[Any, ...] = (),
) -> Iterator[T]:
    """Yield `call(item)` of each item as they come, from so many new processes.

    prepare: called in each process before all else, with what is `given`. An error, or a generator that is
    closed, ends them at once. Errors: those of `call`; concurrent.futures.BrokenExecutor if a process ends.
    """
    spawn, others = get_context("spawn"), active_children()
    with ProcessPoolExecutor(
        processes, mp_context=spawn, initializer=_begin, initargs=(prepare, given)
    ) as pool:
        try:
            with stopping.Deaf():
                futures = [pool.submit(call, item) for item in items]
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            for process in active_children():
                if process not in others:
                    process.kill()
            raise


def _begin(prepare: Callable[..., None] | None, given: tuple[Any, ...]) -> None:
    """Let this process end when the one that has started it does, however that ends, and prepare it."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    if prepare is not None:
        prepare(*given)
