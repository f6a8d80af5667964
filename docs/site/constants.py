"""The tuning constants of the sources, one table for each folder, as a page of the site: constants.py [--check]

A constant is a named `constexpr` number; what is said of it is the comment at the end of its line, or above it or above the group that it is in.
--check only looks whether each has one, and exits with 1 where one has none.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBER = r"(?:double|float|int|long|unsigned|Scalar|(?:Eigen::)?Index|std::size_t|std::ptrdiff_t|std::u?int(?:\d+|max)_t|std::array<(?:double|int|Index|std::size_t), \w+>)"
CONSTANT = re.compile(rf"\s*(?:static |inline )*constexpr {NUMBER} (?P<name>\w+(?:<\w+>)?)(?: = |\{{)(?P<value>.*?)\}}?;\s*(?://[/<!]*\s*(?P<comment>.*))?$")
COMMENT = re.compile(r"\s*//[/<!]*\s?(.*)$")
INTRODUCTION = """# Tuning constants

After this page you know the named numbers of the sources, what they mean and where they come from. What a file can set is in [the list of its keys](experiment.md).
"""


def comment_above(lines: list[str], at: int) -> str:
    """The lines of comment that end above a line."""
    begin = at
    while begin > 0 and COMMENT.match(lines[begin - 1]):
        begin -= 1
    return " ".join(COMMENT.match(line).group(1).strip() for line in lines[begin:at])


def constants(file: Path) -> list[tuple[str, str, str]]:
    """Name, value and comment of each."""
    # What goes on behind "=" is put into one line.
    lines = re.sub(r" =\n\s+", " = ", file.read_text(encoding="utf-8")).splitlines()
    out = []
    group = ""  # comment above the constants that follow each other
    for at, line in enumerate(lines):
        found = CONSTANT.match(line)
        if not found:
            group = ""
            continue
        said = found["comment"] or ""
        # A comment at the end of a line goes on where the next line has nothing else.
        for further in lines[at + 1 :] if said else []:
            more = COMMENT.match(further)
            if not more or len(further) - len(further.lstrip()) < line.find("//"):
                break
            said += " " + more.group(1)
        above = comment_above(lines, at)
        group = above or group
        said = f"{said}; {above}" if said and above else said
        if re.search(r"\d", found["value"]):
            out.append((found["name"], found["value"], said or group))
    return out


def rooms() -> dict[str, list[tuple[str, str, str, str]]]:
    """Name, value, comment and file of the constants of each folder of src, include/rivid and apps."""
    out: dict[str, list[tuple[str, str, str, str]]] = {}
    for top in ("include/rivid", "src", "apps"):
        for file in sorted((ROOT / top).rglob("*.[ch]pp")):
            inside = file.relative_to(ROOT / top).parent.as_posix()
            room = "apps" if top == "apps" else "shared" if inside == "." else inside
            out.setdefault(room, []).extend((*constant, file.relative_to(ROOT).as_posix()) for constant in constants(file))
    return {room: out[room] for room in sorted(out) if out[room]}


def page() -> str:
    def cell(text: str) -> str:
        return text.replace("|", r"\|").replace("<", "&lt;")

    def code(text: str) -> str:
        return "`" + text.replace("|", r"\|") + "`"

    out = INTRODUCTION
    for room, found in rooms().items():
        out += f"\n## {room}\n\n| constant | value | meaning and source | file |\n|---|---|---|---|\n"
        out += "".join(f"| {code(name)} | {code(value)} | {cell(said)} | {code(file)} |\n" for name, value, said, file in found)
    return out


def main() -> int:
    silent = [f"{file}: {name}" for found in rooms().values() for name, _, said, file in found if not said]
    if silent:
        print("constants without a comment that says what they are and where they are from:\n  " + "\n  ".join(silent))
        return 1
    print("each constant is explained" if "--check" in sys.argv else page())
    return 0


if __name__ == "__main__":
    sys.exit(main())
