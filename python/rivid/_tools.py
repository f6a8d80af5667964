"""The command line tools, which lie in bin/ of the package."""

import os
import sys
from pathlib import Path


def main() -> None:
    """Becomes the tool that this program is called after."""
    name = Path(sys.argv[0]).stem
    tool = Path(__file__).parent / "bin" / name
    os.execv(tool, [name, *sys.argv[1:]])
