"""Builds the documentation site, strictly: a broken link, anchor or picture, or a page outside of the navigation, is an error.

    python docs/site/build.py --out build/test/site [--figures FOLDER] [--api build/test/doxygen/html] [--tools build/test/apps]

Pages are those of docs/, README, CONTRIBUTING and CHANGELOG, the READMEs of data/, and the tuning constants of the sources. Other files of the repository that a page
links to are copied beside it. --figures takes freshly drawn figures in place of docs/figures; --tools makes the report pages of the
gallery. A link [text](page.md "made.html") leads to made.html where --api or --tools have made it. --katex is the folder of KaTeX, which
the site ships for its formulas: that of Debian's package libjs-katex.
"""

from __future__ import annotations

import argparse
import logging
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from constants import page as constants_page
from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.config.config_options import ExtraScriptValue
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
        if "://" in target or target.startswith("mailto:"):
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

    parts = re.split(r"(^```.*?^```$|`[^`\n]+`)", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    return "".join(part if part.startswith("`") else LINK.sub(link, part) for part in parts)


def make_reports(tools: Path, folder: Path) -> None:
    """report.html of the robots of the repository, as the gallery's commands make them."""
    with tempfile.TemporaryDirectory() as work:
        for name in ("scara", "six_axis"):
            shutil.copytree(ROOT / "data" / name, Path(work) / name)

        def run(robot: str, tool: str, *arguments: str) -> None:
            subprocess.run([tools / tool, *arguments, "--quiet"], cwd=Path(work) / robot, check=True)

        run("six_axis", "rivid_simulate", "simulate.toml", "--output", "made")
        for robot, name in (("scara", "scara"), ("scara", "scara_iv"), ("six_axis", "six_axis")):
            run(robot, "rivid_identify", f"{name}.toml", "--report", "--output", f"{name}_result")
            shutil.copyfile(Path(work) / robot / f"{name}_result/report.html", folder / f"{name}.html")


def made(folder: Path) -> None:
    """Where a page has a link [text](page.md "made.html") and made.html was made, the link leads there."""

    def link(match: re.Match[str]) -> str:
        return f"]({match.group(2) if (folder / match.group(2)).exists() else match.group(1)})"

    for path in folder.glob("*.md"):
        text = path.read_text(encoding="utf-8")
        path.write_text(re.sub(r'\]\(([^) "]+) "([^"]+\.html)"\)', link, text), encoding="utf-8")


def assemble(folder: Path, figures: Path, api: Path | None, tools: Path | None) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    pages = sources()
    shutil.copytree(ROOT / "docs/figures", folder / "figures")
    if figures != ROOT / "docs/figures":
        shutil.copytree(figures, folder / "figures", dirs_exist_ok=True)
    for name in ("site.css", "formulas.js", "iframe-worker.js"):
        shutil.copyfile(ROOT / "docs/site" / name, folder / name)
    for path, name in pages.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(page(path, name, pages, folder), encoding="utf-8")
    (folder / "constants.md").write_text(constants_page(), encoding="utf-8")
    if api is not None:
        shutil.copytree(api, folder / "api")
    if tools is not None:
        (folder / "reports").mkdir()
        make_reports(tools, folder / "reports")
    made(folder)


def ship_katex(source: Path, folder: Path) -> None:
    for file in [source / "katex.min.js", source / "katex.min.css", *(source / "fonts").glob("*.woff2")]:
        to = folder / "katex" / file.relative_to(source)
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, to)


def unused_figures(folder: Path) -> list[str]:
    text = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*.md"))
    return [path.name for path in sorted((folder / "figures").glob("*.png")) if f"figures/{path.name}" not in text]


def main() -> int:
    parser = argparse.ArgumentParser(description="Builds the documentation site.")
    parser.add_argument("--out", type=Path, required=True, help="folder of the site")
    parser.add_argument("--figures", type=Path, default=ROOT / "docs/figures", help="folder of the figures")
    parser.add_argument("--api", type=Path, help="folder of Doxygen's pages")
    parser.add_argument("--katex", type=Path, default=Path("/usr/share/javascript/katex"), help="folder of KaTeX")
    parser.add_argument("--tools", type=Path, help="folder of the built tools")
    given = parser.parse_args()
    logging.basicConfig(level=logging.WARNING, format="build: %(message)s")
    folder = given.out.resolve().parent / (given.out.name + "_pages")
    api = given.api.resolve() if given.api and given.api.is_dir() else None
    assemble(folder, given.figures.resolve(), api, given.tools.resolve() if given.tools else None)
    if unused := unused_figures(folder):
        raise SystemExit(f"build: no page shows {', '.join(unused)}")
    config = load_config(str(ROOT / "docs/site/mkdocs.yml"), docs_dir=str(folder), site_dir=str(given.out.resolve()))
    if (given.katex / "katex.min.js").is_file():
        ship_katex(given.katex, folder)
        config.extra_css.append("katex/katex.min.css")
        config.extra_javascript += [ExtraScriptValue(name) for name in ("katex/katex.min.js", "formulas.js")]
    else:
        print("build: formulas stay TeX: no KaTeX; apt-get install libjs-katex")
    try:
        build(config)
    except Abort as error:
        raise SystemExit(f"build: {error}") from error
    print(f"build: {len(sources())} pages in {given.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
