"""Read the arguments of commands, and turn mistakes into one sentence."""

from __future__ import annotations

import contextlib
import errno
import sys
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import click

from neve.isa import MAX_THREADS
from neve.ranks import launch
from neve.spelling import hint, nearest
from neve.system import streams

# Errors whose text is a sentence for the user, by module, so that asking for them imports nothing.
USER_ERRORS = (
    ("neve.isa", "IsaError"),
    ("neve.scene.errors", "SceneError"),
    ("neve.io.errors", "RunError"),
    ("neve.render.film", "FilmError"),
    ("neve.render.path_tracing.engine", "RenderError"),
    ("neve.solver", "Blowup"),
    ("neve.ranks.world", "RanksError"),
    ("neve.cuda.errors", "DeviceError"),
    ("neve.system.cluster", "ClusterError"),
    ("neve.viewer.show", "ViewError"),
    ("neve.drive.serve", "DriveError"),
)


class Commands(click.Group):
    """Suggest the nearest command when one is misspelled."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command until standard output takes no more."""
        try:
            return super().invoke(ctx)
        except OSError:
            if streams.output_error() is None:
                raise
            raise SystemExit(2) from None  # `output_code` says why

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that the first argument names."""
        name = args[0]
        if not name.startswith("-") and self.get_command(ctx, name) is None:
            meant = hint(nearest(name, self.commands), f"the commands are {', '.join(self.commands)}")
            raise click.UsageError(f"there is no command {name}{meant}", ctx)
        return super().resolve_command(ctx, args)


def whole_number(ctx: click.Context, param: click.Parameter, value: str | None) -> int | None:
    """Read a whole number of 1 or more."""
    if value is None:
        return None
    if not (value.isascii() and value.isdigit() and len(value) < 20 and int(value) >= 1):
        raise click.BadParameter(f"{value} is not a whole number of 1 or more", ctx, param)
    return int(value)


def thread_count(ctx: click.Context, param: click.Parameter, value: str | None) -> int | None:
    """Read a number of threads that the system can start."""
    number = whole_number(ctx, param, value)
    if number is not None and number > MAX_THREADS:
        sentence = f"{number} is more than {MAX_THREADS}, four threads for each processor"
        raise click.BadParameter(sentence, ctx, param)
    return number


def report(sentence: str) -> None:
    """Say a sentence on standard error; of several ranks one does."""
    if launch.leads():
        print(f"neve: {' '.join(sentence.split())}", file=sys.stderr, flush=True)


@contextlib.contextmanager
def others_reported(reported: Iterable[str] = ()) -> Iterator[None]:
    """Print each warning about the scene once, as the command line does; skip those already `reported`."""
    from neve.scene.errors import SceneWarning

    seen = set(reported)

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if not issubclass(category, SceneWarning):
            usual(message, category, *where, **more)
        elif str(message) not in seen:
            seen.add(str(message))
            report(f"warning: {message}.")

    with warnings.catch_warnings():
        usual = warnings.showwarning
        warnings.simplefilter("always", SceneWarning)
        warnings.showwarning = show
        yield


def tell(sentence: str) -> None:
    """Say a sentence on standard output, if somebody listens: a server goes on without."""
    steady = streams.Steady(sys.stdout)
    steady.write(f"{sentence}\n")
    steady.flush()


def output_code(code: int) -> int:
    """Return the exit code of a command that ends with `code`, once all that it printed is out.

    A disk that takes no more is told; a reader that has gone ends the command without a word.
    """
    refused = streams.output_error()
    if refused is None:
        return code
    if refused.errno == errno.EPIPE:
        return streams.GONE
    from neve.io.errors import reason

    report(f"standard output could not be written: {reason(refused)}.")
    return 2


def user_error(error: Exception) -> str | None:
    """Return the sentence for an error that the user can fix, None for a bug in Neve."""
    if isinstance(error, MemoryError):
        return "this needs more memory than the machine has: choose a larger numerics.dx or less snow."
    for module, name in USER_ERRORS:
        known = getattr(sys.modules.get(module), name, None)
        if known is not None and isinstance(error, known):
            return str(error)
    if isinstance(error, OSError):  # last resort: code that touches files says more
        from neve.io.errors import reason

        return f"{error.filename}: {reason(error)}." if error.filename else f"{reason(error)}."
    return None


def usage(error: click.ClickException) -> str:
    """Turn an error of click into one sentence with the nearest correct spelling."""
    if isinstance(error, click.NoSuchOption):
        parameters = error.ctx.command.params if error.ctx else []
        known = [name for parameter in parameters for name in parameter.opts if name.startswith("--")]
        meant = hint(nearest(error.option_name, known), f"the options are {', '.join(known)}")
        return f"there is no option {error.option_name}{meant}"
    if isinstance(error, click.MissingParameter) and error.param is not None:
        return f"{(error.param.name or '').upper()} is missing: see {_command(error)} --help"
    if isinstance(error, click.BadParameter) and error.param is not None:
        return f"{error.param.opts[0]}: {error.message}"
    message = error.format_message().rstrip(".")
    return message[:1].lower() + message[1:] if message[:1].isupper() and message[1:2].islower() else message


def _command(error: click.UsageError) -> str:
    return error.ctx.command_path if error.ctx else "neve"
