"""Work over many scans, on this machine's cores or on a Dask cluster, through joblib.

Workers of a cluster need this project installed, and nothing else: they are sent the bytes of the
files and arrays, and answer with arrays. No folder has to be shared with them.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from joblib import Parallel, delayed, parallel_config

ANSWERS_WITHIN = 10.0
"""Seconds in which a scheduler must answer."""


@contextmanager
def workers(jobs: int, dask: str | None) -> Iterator[str]:
    """Where :func:`each` works within this context; yields it in words.

    Parameters
    ----------
    jobs : processes on this machine; -1 for one a core.
    dask : the address of a Dask scheduler, such as ``tcp://127.0.0.1:8786``, in place of them.

    Raises
    ------
    OSError
        Where no scheduler answers.
    ModuleNotFoundError
        Where dask.distributed is not installed.
    """
    if dask is None:
        with parallel_config(backend="loky", n_jobs=jobs):
            yield "this machine"
        return
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise ModuleNotFoundError("--dask needs a package: pip install distributed") from None
    client: Any = Client(dask, timeout=ANSWERS_WITHIN)  # type: ignore[no-untyped-call]
    with client, parallel_config(backend="dask", client=client):
        yield f"{sum(client.ncores().values())} threads of the Dask cluster at {dask}"


def each(
    work: Callable[..., Any], tasks: Iterable[tuple[Any, ...]], say: str, total: int
) -> Iterator[Any]:
    """The results of `work(*task)` in the order of the tasks, which are made as they are needed.

    Shows progress: `say` is a sentence with places for how many are done and the total.
    """
    results = Parallel(return_as="generator")(delayed(work)(*task) for task in tasks)
    for done, result in enumerate(results, 1):
        yield result
        print("\r" + say.format(done, total), end="", flush=True)
    print()
