"""Atomic output: a folder or a file of results appears whole or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import signal
import tempfile
import threading
from collections.abc import Collection, Iterator
from pathlib import Path

from mjfriction.errors import OutputError


@contextlib.contextmanager
def whole_folder(target: Path, ours: Collection[str] = ()) -> Iterator[Path]:
    """Yield a hidden folder beside the target to write into; its files move into the target when all are written.

    Files of ``ours`` that an earlier run left in the target, and that are not written now, are removed: they would
    stand beside results that they do not belong to.

    Raises :class:`OutputError` at once when the target cannot be written; leaves nothing behind on any failure.
    """
    target = target.absolute()
    if target.exists() and not target.is_dir():
        raise OutputError(f"{target}: is a file; give a folder to write the results to")
    # The name is chosen before the folder exists, so that after an interrupt at any moment the folder is removed.
    draft = target.parent / f".{target.name}-{secrets.token_hex(8)}"
    try:
        _make(draft, target)
        yield draft
        if target.is_dir():
            written = sorted(draft.iterdir())
            for entry in written:
                os.replace(entry, target / entry.name)
            for name in ours:
                if draft / name not in written:
                    (target / name).unlink(missing_ok=True)
        else:
            draft.chmod(0o755)
            os.replace(draft, target)
    finally:
        with undisturbed():
            shutil.rmtree(draft, ignore_errors=True)


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """Ignore keyboard interrupts: the cleanup after one must not be cut short by the next."""
    if threading.current_thread() is not threading.main_thread():  # only the main thread receives interrupts
        yield
        return
    heeded = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if heeded is None else heeded)


def _make(draft: Path, target: Path) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.is_dir() and not os.access(target, os.W_OK | os.X_OK):
            raise PermissionError(13, "no permission to write there")
        draft.mkdir(mode=0o700)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{target}: cannot be written: {reason.lower()}; give another folder with --out") from None


@contextlib.contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Yield a hidden path beside the target to write to; the file replaces the target when it is complete.

    Raises :class:`OutputError` when the target cannot be written.
    """
    target = target.absolute()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{target.stem}-", suffix=target.suffix, dir=target.parent)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{target}: cannot be written: {reason.lower()}; give another place with --out") from None
    os.close(handle)
    draft = Path(name)
    try:
        yield draft
        draft.chmod(0o644)
        os.replace(draft, target)
    except OSError as error:
        raise OutputError(f"{target}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    finally:
        with undisturbed():
            draft.unlink(missing_ok=True)
