"""The command `vsensor`: finds the command that is called, and turns its errors into an exit status."""

import os
import sys
from importlib import import_module
from keyword import iskeyword
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from vsensor.cli.output import Output, open_closed
from vsensor.errors import VsensorError
from vsensor.signals import end_cleanly_when_terminated

# Command → its line in `vsensor --help`. Command X is the function X in vsensor/cli/X.py, with an
# underscore behind it where Python has taken the word: import_ in import_.py.
COMMANDS = {
    "demo": "Show the whole of it on this machine: simulated rig, sensor, recording, live view.",
    "check": "Explain a configuration: delays, impedances, modes, and what looks odd.",
    "run": "Run the virtual sensor beside a rig's telemetry.",
    "status": "Ask a running sensor how it is, and show it live.",
    "tell": "Tell a running sensor of bit and string, or what to record.",
    "view": "Show a running sensor live.",
    "simulate": "Publish a simulated rig's surface torque and speed.",
    "replay": "Publish a session's surface samples as if live.",
    "estimate": "Run the estimator over a file, as fast as it goes.",
    "verify": "Run a session's inputs again: every estimate must come out bit for bit.",
    "import": "Make a session of a table.",
    "export": "Make a table of a session.",
    "report": "Tell what happened in a session, on one page.",
    "info": "Say what is in a session.",
    "recover": "Mend a torn session.",
    "paper": "Reproduce the paper's figures and tables, and judge them.",
    "bench": "Measure speed and lateness, each beside its yardstick.",
}


class _Commands(TyperGroup):
    """Lists every command and imports only the one that is called: help needs no Zenoh, Rerun or Numba."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        for name, line in COMMANDS.items():
            self.add_command(TyperCommand(name, help=line))

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """Find the called command, and load what it does."""
        name, listed, rest = super().resolve_command(ctx, args)
        return name, listed and _load(str(name)), rest

    def invoke(self, ctx: Any) -> Any:
        """Run the command; a VsensorError is a message and an exit status, not a traceback."""
        try:
            return super().invoke(ctx)
        except VsensorError as error:
            typer.secho("error: ", fg="red", bold=True, err=True, nl=False)
            typer.echo(error, err=True)
            raise typer.Exit(error.exit_status) from error


def _load(name: str) -> Any:
    python_name = f"{name}_" if iskeyword(name) else name
    module = import_module(f"vsensor.cli.{python_name}")
    command = typer.Typer(add_completion=False)
    command.command(name)(getattr(module, python_name))
    return typer.main.get_command(command)


app = typer.Typer(cls=_Commands, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)


def _print_version(wanted: bool) -> None:
    if wanted:
        from vsensor import __version__

        typer.echo(f"vsensor {__version__}")
        raise typer.Exit


@app.callback()
def _vsensor(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit."),
    ] = False,
) -> None:
    """A virtual torque sensor for the bit of a drill string, from surface torque and speed."""


def main() -> None:
    """Run the command line.

    Exit status 0 done, 1 the work failed, 2 wrong use, 130 stopped by Ctrl-C, 143 by SIGTERM.
    """
    end_cleanly_when_terminated()
    open_closed()
    output = Output.standard()
    sys.stdout = output
    try:
        app()
    except OSError as error:
        if error is not output.failure:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), output.fileno())  # for what still waits to be written
        sys.exit(f"error: standard output: cannot be written: {error.strerror}")


if __name__ == "__main__":
    main()
