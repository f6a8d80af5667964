"""Names comments and prose of Markdown beyond 110 characters a line: lines.py SOURCES

Tables, code, and what has no blank to be broken at may be longer.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import unicodedata

MOST = 110
COMMENTS = {".hpp": "//", ".cpp": "//", ".h": "//", ".in": "#", ".py": "#", ".cmake": "#", ".txt": "#", ".sh": "#", ".toml": "#"}
WHOLE = re.compile(r"(`[^`]*`|\[[^\]]*\]\([^)]*\)|\$[^$]*\$|\S)+")  # code, links and formulas


def width(line):
    """Characters side by side: the dot of q̇ stands above."""
    return sum(not unicodedata.combining(character) for character in line)


def can_be_broken(line):
    parts = [part.start() for part in WHOLE.finditer(line)]
    return width(line) > MOST and any(start <= MOST for start in parts[2:])


def prose(text):
    """Lines of Markdown outside of code, tables, headings and HTML, with their numbers."""
    fence = ""
    for number, line in enumerate(text.splitlines(), 1):
        start = line.lstrip()
        mark = re.match(r"```+|~~~+|\$\$$", start)
        if mark:
            fence = "" if fence == mark.group(0) else fence or mark.group(0)
        elif not fence and not start.startswith(("|", "#", "<", "![")):
            yield number, line


def comments(text, mark):
    """Lines that are comments, or end in one, of a language with marks of them."""
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(rf"\s*{mark}[/<]*( (?! |\||`)|$)", line):
            yield number, line


def main():
    sources = pathlib.Path(sys.argv[1]).resolve()
    git = ["git", "ls-files", "-z"]
    listed = subprocess.run(git, cwd=sources, capture_output=True, text=True, check=False) if shutil.which("git") else None
    if listed is None or listed.returncode != 0:
        print("skipped: no git, or no files of it")
        return 0
    wrong = []
    for name in filter(None, listed.stdout.split("\0")):
        file = sources / name
        if not file.is_file():
            continue
        if file.suffix == ".md":
            lines = prose(file.read_text(encoding="utf-8"))
        elif file.suffix in COMMENTS:
            lines = comments(file.read_text(encoding="utf-8"), COMMENTS[file.suffix])
        else:
            continue
        wrong += [f"{name}:{number}: {width(line)} characters" for number, line in lines if can_be_broken(line)]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
