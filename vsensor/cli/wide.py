"""A console on which no table's figures are cut short."""

from typing import Any

from rich.console import Console

PIPE_WIDTH = 120
"""Columns of text when nobody's window sets them."""
NARROWEST = 100
"""In a narrower window the window itself breaks the lines: a figure without its end would be another one."""


def wide_console(**settings: Any) -> Console:
    """Rich's console, with room for our tables whatever the window."""
    console = Console(**settings)
    console.width = max(console.width, NARROWEST) if console.is_terminal else PIPE_WIDTH
    return console
