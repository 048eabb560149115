"""Which documents can be reproduced, and all of them at once."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from importlib import import_module

from mjfriction.reproduce.outcome import Reproduction

DOCUMENTS = ("table", "hydraulic", "manipulator")


def reproduce(
    documents: Sequence[str], progress: Callable[[str], None], *, seed: int = 0, jobs: int = 1
) -> list[Reproduction]:
    """Run the experiments of documents by name, ``jobs`` at a time, and return them in their order.

    ``progress`` is told what is going on.  The results are the same whatever ``jobs`` is.
    """
    if jobs == 1 or len(documents) == 1:
        return [_run(name, seed, partial(_told, progress, name)) for name in documents]
    # Fresh processes: the one MuJoCo callback and what is compiled belong to a process.
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        # The longest first.
        running = {name: pool.submit(_run, name, seed) for name in sorted(documents, key=DOCUMENTS.index, reverse=True)}
        out = []
        for k, name in enumerate(documents):
            progress(f"{', '.join(documents[k:])} in {jobs} processes")
            out.append(running[name].result())
        return out


def _run(name: str, seed: int, progress: Callable[[str], None] | None = None) -> Reproduction:
    run = getattr(import_module(f"mjfriction.reproduce.{name}.told"), f"reproduce_{name}")
    found = run(progress or _silent, seed)
    assert isinstance(found, Reproduction)
    return found


def _told(progress: Callable[[str], None], document: str, step: str) -> None:
    progress(f"{document}: {step}")


def _silent(step: str) -> None:
    del step
