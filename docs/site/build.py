"""Builds the documentation site, strictly: a broken link, anchor or picture, or a page outside of the navigation, is an error.

    python docs/site/build.py --out build/test/site [--figures FOLDER] [--api build/test/doxygen/html]

Pages are those of docs/, README, CONTRIBUTING and CHANGELOG, and the READMEs of data/. Other files of the repository that a page
links to are copied beside it. --figures takes freshly drawn figures in place of docs/figures; without --api, links to the API
pages lead to the text of docs/api.md.
"""

from __future__ import annotations

import argparse
import logging
import re
import shutil
import sys
from pathlib import Path

from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.exceptions import Abort

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"(\]\()([^)#\s]+)")


def sources() -> dict[Path, str]:
    """Pages of the site: file of the repository, name on the site."""
    pages = {path: path.name for path in sorted((ROOT / "docs").glob("*.md"))}
    pages |= {ROOT / f"{name.upper()}.md": f"{name}.md" for name in ("readme", "contributing", "changelog")}
    return pages | {path: f"data/{path.parent.name}.md" for path in sorted((ROOT / "data").glob("*/README.md"))}


def up(name: str) -> str:
    """The way from a page to the root of the site."""
    return "../" * name.count("/")


def page(path: Path, name: str, pages: dict[Path, str], folder: Path) -> str:
    """Text of a page, whose links lead to pages of the site, figures, or copies of files."""

    def link(match: re.Match[str]) -> str:
        target = match.group(2)
        if "://" in target or target.startswith(("mailto:", "api/")):
            return match.group(0)
        file = (path.parent / target).resolve()
        if file in pages:
            return match.group(1) + up(name) + pages[file]
        if file.parent == ROOT / "docs/figures":
            return match.group(1) + up(name) + "figures/" + file.name
        if file.is_file() and file.is_relative_to(ROOT):
            copy = Path("source") / file.relative_to(ROOT)
            copy = copy.with_name(copy.name + ".txt")
            (folder / copy).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, folder / copy)
            return match.group(1) + up(name) + str(copy)
        raise SystemExit(f"build: {path.relative_to(ROOT)} links to {target}, which is no file of the repository")

    parts = re.split(r"(^```.*?^```$)", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return "".join(part if part.startswith("```") else LINK.sub(link, part) for part in parts)


def assemble(folder: Path, figures: Path, api: Path | None) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    pages = sources()
    shutil.copytree(ROOT / "docs/figures", folder / "figures")
    if figures != ROOT / "docs/figures":
        shutil.copytree(figures, folder / "figures", dirs_exist_ok=True)
    shutil.copyfile(ROOT / "docs/site/site.css", folder / "site.css")
    for path, name in pages.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(page(path, name, pages, folder), encoding="utf-8")
    if api is not None:
        shutil.copytree(api, folder / "api")
    else:
        text = (folder / "api.md").read_text(encoding="utf-8").replace("(api/index.html)", "(#the-library)")
        (folder / "api.md").write_text(text, encoding="utf-8")


def unused_figures(folder: Path) -> list[str]:
    text = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*.md"))
    return [path.name for path in sorted((folder / "figures").glob("*.png")) if f"figures/{path.name}" not in text]


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds the documentation site.")
    parser.add_argument("--out", type=Path, required=True, help="folder of the site")
    parser.add_argument("--figures", type=Path, default=ROOT / "docs/figures", help="folder of the figures")
    parser.add_argument("--api", type=Path, help="folder of Doxygen's pages")
    given = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, format="build: %(message)s")
    folder = given.out.resolve().parent / (given.out.name + "_pages")
    assemble(folder, given.figures.resolve(), given.api.resolve() if given.api and given.api.is_dir() else None)
    if unused := unused_figures(folder):
        raise SystemExit(f"build: no page shows {', '.join(unused)}")
    config = load_config(str(ROOT / "docs/site/mkdocs.yml"), docs_dir=str(folder), site_dir=str(given.out.resolve()))
    try:
        build(config)
    except Abort as error:
        raise SystemExit(f"build: {error}") from error
    print(f"build: {len(sources())} pages in {given.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
