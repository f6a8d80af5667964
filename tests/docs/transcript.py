"""Types the commands of a page's ```console blocks, in a folder of their own: transcript.py PAGE FOLDER_OF_THE_PROGRAM.

What the page shows of each answer is what the program prints, in its order; "…" stands for lines that are left out, and for the folder.
"""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile


def main():
    page, tools = pathlib.Path(sys.argv[1]), os.path.abspath(sys.argv[2])
    shown = "".join(re.findall(r"```console\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL))
    steps = re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", shown, flags=re.MULTILINE)
    environment = {**os.environ, "PATH": tools + os.pathsep + os.environ["PATH"], "DISPLAY": "", "WAYLAND_DISPLAY": ""}
    typed = [command for command, _ in steps if command.startswith("rivid ")]
    if not 4 <= len(typed) <= 8:
        return f"{page.name}: {len(typed)} commands of rivid"
    with tempfile.TemporaryDirectory() as folder:
        for command, answer in steps:
            if command not in typed:
                continue
            done = subprocess.run(shlex.split(command), cwd=folder, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            printed = iter(done.stdout.replace(os.path.realpath(folder), "…").replace(folder, "…").splitlines())
            for line in answer.splitlines():
                if line not in ("", "…") and line not in printed:
                    return f"{page.name}: $ {command}\n{done.stdout}\ndoes not print, or not there:\n{line}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
