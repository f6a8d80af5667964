"""The program `rivid`, which lies in bin/ of the package, and by its old names the tools that became subcommands of it."""

import os
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent / "bin" / "rivid"


def program() -> Path:
    """The program: in the package, or where RIVID_TOOLS says."""
    return Path(os.environ["RIVID_TOOLS"]) / "rivid" if "RIVID_TOOLS" in os.environ else PROGRAM


def main() -> None:
    """Becomes that program, under the name that this one is called by."""
    os.execv(PROGRAM, [Path(sys.argv[0]).stem, *sys.argv[1:]])
