"""Work on a Dask cluster: one of this machine, or the one whose scheduler has an address."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from neve.system import stopping

T = TypeVar("T")
_ONE = threading.Lock()
WAIT = 30.0
"""Wall time to wait for a scheduler that has an address [s]."""


class ClusterError(RuntimeError):
    """One sentence for the user: why there is no cluster to work on."""


def require_dask() -> None:
    """Raise ClusterError, in one sentence, if Dask is not installed."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise ClusterError(f"this needs Dask ({error}): pip install distributed.") from None


@contextlib.contextmanager
def cluster(workers: int, scheduler: str | None = None) -> Iterator[Any]:
    """Return a client of so many new processes here, or of the cluster whose scheduler has that address.

    A process does one thing at a time, on as many threads as that wants. Leaving the block ends the processes
    here, whatever they are at; of a cluster elsewhere, only what was asked of it.

    Errors: ClusterError without Dask, or if nothing answers at the address.
    """
    require_dask()
    import dask
    from distributed import Client, LocalCluster

    with dask.config.set({"distributed.worker.daemon": True}), contextlib.ExitStack() as stack:
        if scheduler is not None:
            try:
                client = Client(scheduler, timeout=WAIT)
            except (OSError, TimeoutError, ValueError) as error:
                raise ClusterError(
                    f"--scheduler {scheduler}: nothing answers there as a scheduler of Dask does"
                    f" ({type(error).__name__}); write its address, such as tcp://host:8786."
                ) from None
        else:
            with stopping.Deaf():  # Ctrl-C is for this process, which ends the others
                local = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    memory_limit=0,
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            stack.enter_context(local)
            client = Client(local)
        yield stack.enter_context(client)


def results(
    client: Any, call: Callable[..., T], items: Sequence[Any], *given: Any
) -> Iterator[tuple[int, T | BaseException]]:
    """Yield the number of an item and `call(item, *given)`, or what it raised, as they come.

    A process does one item at a time, however many its scheduler lets it have. What a process was at that has
    ended is done again by another one, three times at most.
    """
    from distributed import as_completed

    futures = [client.submit(_alone, call, item, *given, pure=False) for item in items]
    number = {future.key: k for k, future in enumerate(futures)}
    try:
        for future in as_completed(futures):
            error = future.exception()
            yield number[future.key], future.result() if error is None else error
            future.release()
    finally:
        client.cancel(futures)


def _alone(call: Callable[..., T], *given: Any) -> T:
    with _ONE:
        return call(*given)


def threads_here() -> int | None:
    """Return how many threads the worker of a cluster has that this process is; None if it is none."""
    try:
        from distributed import get_worker

        return int(get_worker().state.nthreads)
    except (ImportError, ValueError):
        return None


def elsewhere(scheduler: str, call: Callable[..., T], items: Sequence[Any], *given: Any) -> Iterator[T]:
    """Yield `call(item, *given)` of each item as they come from the cluster whose scheduler has that address.

    Errors: the first that a call raises; ClusterError.
    """
    with cluster(1, scheduler) as client:
        for _, found in results(client, call, items, *given):
            if isinstance(found, BaseException):
                ended = ClusterError(f"processes of the cluster {scheduler} have ended again and again.")
                raise ended if is_killed(found) else found
            yield found


def is_killed(error: BaseException) -> bool:
    """Tell whether the processes that did something ended again and again."""
    return type(error).__name__ == "KilledWorker"
