"""Compares the table of rooms in CONTRIBUTING.md with the sources: size.py SOURCES [--write]

Code lines are those that are neither blank nor a comment alone, in hundreds. Exit code 1 where the table says other figures; --write writes them.
"""

import pathlib
import re
import sys

ROOMS = ["model", "signal", "data", "solve", "regressor", "simulate", "identify", "excite", "online", "experiment",
         "report", "export"]
CODE = {".hpp", ".cpp", ".h", ".in"}
COMMENT = re.compile(r"\s*(//.*)?")
HEAD = "| room | code lines | files | public headers |\n|---|---|---|---|\n"


def counted(files):
    lines = sum(not COMMENT.fullmatch(line) for file in files for line in file.read_text(encoding="utf-8").splitlines())
    headers = sum("include" in file.parts for file in files)
    return round(lines, -2), len(files), headers


def table(sources):
    files = [path.relative_to(sources) for top in ("include/rivid", "src") for path in sorted((sources / top).rglob("*"))
             if path.suffix in CODE]
    rooms = {room: [] for room in ROOMS} | {"others": []}
    for file in files:
        room = file.parts[2 if file.parts[0] == "include" else 1]
        rooms.get(room, rooms["others"]).append(sources / file)
    rooms["all"] = [sources / file for file in files]
    rows = [f"| {room} | {lines} | {count} | {headers} |\n"
            for room, (lines, count, headers) in ((room, counted(of)) for room, of in rooms.items())]
    return HEAD + "".join(rows)


def main():
    sources = pathlib.Path(sys.argv[1]).resolve()
    page = sources / "CONTRIBUTING.md"
    text = page.read_text(encoding="utf-8")
    begin = text.find(HEAD)
    if begin < 0:
        sys.exit(f"{page}: has no table of rooms")
    end = text.find("\n\n", begin) + 1
    wanted = table(sources)
    if "--write" in sys.argv:
        page.write_text(text[:begin] + wanted + text[end:], encoding="utf-8")
    elif text[begin:end] != wanted:
        print(f"{page}: the sources say\n\n{wanted}\nsize.py SOURCES --write writes it")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
