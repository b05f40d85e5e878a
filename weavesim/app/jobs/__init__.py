"""Commands for jobs: a forming run as a file. Each command is a module of this folder."""

from __future__ import annotations

import typer

from .check import check_command
from .form import form_command
from .new import new_command
from .rerun import rerun_command
from .view import view_command


def add_commands(application: typer.Typer) -> None:
    """Add the commands to the command line."""
    application.command("new")(new_command)
    application.command("check")(check_command)
    application.command("form")(form_command)
    application.command("view")(view_command)
    application.command("rerun")(rerun_command)
