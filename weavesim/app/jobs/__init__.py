"""Commands for jobs: a forming run as a file. Each command is a module of this folder."""

from __future__ import annotations

import typer

from .form import form_command


def add_commands(application: typer.Typer) -> None:
    """Add the commands to the command line."""
    application.command("form")(form_command)
