"""The documents that can be reproduced, and a function that runs several of them."""

from __future__ import annotations

import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module

from mjfriction.progress import Tell, silently
from mjfriction.reproduce.outcome import Reproduction

DOCUMENTS = ("table", "hydraulic", "manipulator")


def reproduce(documents: Sequence[str], tell: Tell = silently, *, seed: int = 0, jobs: int = 1) -> list[Reproduction]:
    """Run the experiments of documents by name, ``jobs`` at a time, and return them in their order.

    ``tell`` receives progress reports.  The results are the same whatever ``jobs`` is.
    """
    if jobs == 1 or len(documents) == 1:
        return [_run(name, seed, _part(tell, k, documents)) for k, name in enumerate(documents)]
    # Fresh processes: each process has its own MuJoCo callback and compiled code.
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        # Start the longest first.
        running = {name: pool.submit(_run, name, seed) for name in sorted(documents, key=DOCUMENTS.index, reverse=True)}
        out = []
        for k, name in enumerate(documents):
            tell(f"{', '.join(documents[k:])} in {jobs} processes", k / len(documents))
            out.append(running[name].result())
        return out


def _run(name: str, seed: int, tell: Tell = silently) -> Reproduction:
    run = getattr(import_module(f"mjfriction.reproduce.{name}.told"), f"reproduce_{name}")
    found = run(tell, seed)
    assert isinstance(found, Reproduction)
    return found


def _part(tell: Tell, number: int, documents: Sequence[str]) -> Tell:
    # Report the progress of one document's experiments as a part of the whole.
    def told(step: str, done: float | None = None) -> None:
        tell(f"{documents[number]}: {step}", (number + (done or 0.0)) / len(documents))

    return told
