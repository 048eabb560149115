"""The ``mjfriction`` command: its verbs, and how failures are reported to the user."""

from __future__ import annotations

import gc
import signal
import sys
from typing import Annotated, NoReturn

import typer
from typer import core, exceptions

from mjfriction.cli.compare import compare
from mjfriction.cli.demo import demo
from mjfriction.cli.diagnose import diagnose
from mjfriction.cli.export import export
from mjfriction.cli.identify import identify
from mjfriction.cli.inspect import inspect
from mjfriction.cli.laws import laws
from mjfriction.cli.new import new
from mjfriction.cli.observe import observe
from mjfriction.cli.plan import plan
from mjfriction.cli.predict import predict
from mjfriction.cli.reproduce import reproduce
from mjfriction.cli.simulate import simulate
from mjfriction.cli.view import view
from mjfriction.errors import InputError

WRONG_INPUT, OWN_FAILURE, INTERRUPTED = 2, 1, 130
STOPPED = "stopped; nothing was written"
# Allocations between collections of reference cycles: a command creates few cycles, and runs for seconds.
ALLOCATIONS = 50_000

app = typer.Typer(
    name="mjfriction",
    help="Say what a MuJoCo model of a manipulator gets wrong, name the cause, extend the model, measure the gain.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=True,
)
for verb in (
    compare,
    demo,
    diagnose,
    export,
    identify,
    inspect,
    laws,
    new,
    observe,
    plan,
    predict,
    reproduce,
    simulate,
    view,
):
    app.command()(verb)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"mjfriction {version('mjfriction')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    del version


def run() -> None:
    """Run the command; exit 0 on success, 2 for wrong input and 1 for an internal error, with one line on stderr."""
    gc.set_threshold(ALLOCATIONS)
    if len(sys.argv) == 1:
        sys.argv.append("--help")
    command = typer.main.get_command(app)
    assert isinstance(command, core.TyperGroup)
    try:
        status = command.main(standalone_mode=False)
    except InputError as error:
        _stop(f"{error}", WRONG_INPUT)
    except (KeyboardInterrupt, exceptions.Abort):
        _interrupted()
    except Exception as error:
        message = _usage_message(error)
        if message is None:
            _stop(f"internal error, please report it: {type(error).__name__}: {error}", OWN_FAILURE)
        else:
            _stop(message, WRONG_INPUT)
    if status == INTERRUPTED:
        _interrupted()
    sys.exit(status if isinstance(status, int) else 0)


def _usage_message(error: Exception) -> str | None:
    # The command parser's errors carry a message and the context in which they occurred.
    text = getattr(error, "format_message", None)
    if text is None:
        return None
    context = getattr(error, "ctx", None)
    where = context.command_path if context is not None else "mjfriction"
    return f"{str(text()).splitlines()[0].removesuffix('.')}. See '{where} --help'."


def _interrupted() -> NoReturn:
    # A second Ctrl-C while the message is printed would give a traceback instead, and another exit status.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _stop(STOPPED, INTERRUPTED)


def _stop(message: str, status: int) -> NoReturn:
    print(f"mjfriction: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(status)
