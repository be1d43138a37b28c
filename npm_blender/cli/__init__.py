"""The command line: one tree for `npmesh VERB`, `python -m npm_blender VERB` and `blender --command npmesh VERB`.

In: arguments. Out: files, data on standard output, progress and one-line errors on standard error, an exit code:
0 done, 1 failed (disk, memory, cancelled, our bug), 2 bad usage or bad input (repeating the command will not help).
Nothing heavy is imported until a verb runs, so `--help` answers at once and needs no dependency.
"""

import argparse
import os
import sys
import traceback
from collections.abc import Sequence
from typing import NoReturn

from ..core.errors import Cancelled, NpmError
from ..version import __version__
from . import compress, decompress, demo, evaluate, info

VERBS = (compress, decompress, info, evaluate, demo)
DONE, FAILED, BAD_INPUT = 0, 1, 2


class _Help(argparse.RawDescriptionHelpFormatter):
    """Descriptions as written, and room for the longest verb before its help."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=26, width=110)


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line, as all our errors are."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and where help is, and leave with exit code 2."""
        self.exit(BAD_INPUT, f"{self.prog}: error: {' '.join(message.split())}; see {self.prog} --help\n")


def build_parser(prog: str) -> argparse.ArgumentParser:
    """The whole argument tree under the name `prog`; each verb's namespace carries its function as `run`."""
    parser = OneLineParser(
        prog=prog,
        allow_abbrev=False,
        formatter_class=_Help,
        description=(
            "Compress triangle meshes into progressive .npmesh files: a coarse base mesh, then features that add\n"
            "detail, the coarsest first, so any prefix of the file past the base shows the whole shape."
        ),
    )
    parser.add_argument("--version", action="version", version=f"npmesh {__version__}", help="show the version and exit")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for verb in VERBS:
        name = verb.__name__.rpartition(".")[2]
        sub = verbs.add_parser(
            name, help=verb.HELP, description=verb.__doc__, allow_abbrev=False, formatter_class=_Help
        )
        verb.add_arguments(sub)
        sub.set_defaults(run=verb.run, parser=sub)
    return parser


def main(argv: Sequence[str], prog: str = "python -m npm_blender") -> int:
    """Run one command and return its exit code; never raises for a user's mistake, nor calls sys.exit.

    argv: the arguments after the program's name; prog: that name, as the user typed it, for messages.
    """
    try:
        args = build_parser(prog).parse_args(list(argv))
    except SystemExit as leaving:  # --help, --version and usage errors
        return int(leaving.code or DONE)
    try:
        args.run(args)
        sys.stdout.flush()
        return DONE
    except SystemExit as leaving:  # a usage error that only the verb can see
        return int(leaving.code or DONE)
    except (KeyboardInterrupt, Cancelled):
        return _say(prog, "cancelled; no output was written", FAILED)
    except NpmError as error:
        return _say(prog, str(error), BAD_INPUT)
    except ModuleNotFoundError as error:
        if (error.name or __name__).startswith(__name__.partition(".cli")[0]):
            return _bug(prog)
        return _say(
            prog, f"Expected the package {error.name}, found none; run pip install -r requirements/run.txt", FAILED
        )
    except BrokenPipeError:  # the reader of our output closed it (`... | head`): nobody is left to tell
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except OSError as error:
        where = f": {error.filename}" if error.filename else ""
        return _say(prog, f"{error.strerror or error}{where}", FAILED)
    except MemoryError:
        return _say(prog, "out of memory; close other programs, or decimate the mesh first", FAILED)
    except Exception:
        return _bug(prog)


def npmesh() -> int:
    """The command `npmesh` that pip installs; the script around it leaves with the exit code."""
    return main(sys.argv[1:], prog="npmesh")


def _say(prog: str, message: str, code: int) -> int:
    """Print one error line below whatever the progress line left, and pass the exit code on."""
    print(f"{prog}: error: {' '.join(message.split())}", file=sys.stderr, flush=True)
    return code


def _bug(prog: str) -> int:
    """Called in an except clause: print the traceback, for whoever mends it, and a last line for the user."""
    traceback.print_exc()
    return _say(prog, "this is a bug in npm_blender; please report it with the lines above", FAILED)
