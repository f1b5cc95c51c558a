"""The argument parser of our programs: bad arguments take one line and exit code 2."""

from __future__ import annotations

import argparse
from typing import NoReturn


class OneLineParser(argparse.ArgumentParser):
    """A parser that answers bad arguments with one line on standard error and exit code 2."""

    def error(self, message: str) -> NoReturn:
        """Print what is wrong and where help stands, and leave with code 2."""
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")
