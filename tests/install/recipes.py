"""recipes.py SOURCE_DIR [--package-xml]

The recipes of packaging/, debian/ and package.xml have the version of the project and name each dependency of packages.txt by the name that the table
of packaging/README.md gives it. With --package-xml alone: catkin_pkg, if it is installed, reads package.xml without a complaint.
"""

from __future__ import annotations

import json
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

SKIPPED = 77


def table(page: str) -> dict[str, dict[str, str]]:
    """The table of dependencies: Debian's name to the names of the others."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if line.startswith("|")]
    heading = rows[0]
    return {row[0]: dict(zip(heading[1:], row[1:])) for row in rows[2:] if len(row) == len(heading)}


def names(root: Path) -> dict[str, tuple[str | None, set[str]]]:
    """Of each recipe its version, where it states one, and the packages it asks for."""
    manifest = ElementTree.parse(root / "package.xml").getroot()
    keys = {child.text for child in manifest if child.tag.endswith("depend") and child.text}
    conda = (root / "packaging/conda/recipe.yaml").read_text()
    host = conda[conda.index("  host:\n") : conda.index("  run:\n")]
    port = json.loads((root / "packaging/vcpkg/rivid/vcpkg.json").read_text())
    conan = (root / "packaging/conan/conanfile.py").read_text()
    debian = (root / "debian/control").read_text()
    brew = (root / "packaging/homebrew/rivid.rb").read_text()

    def found(pattern: str, text: str) -> str:
        match = re.search(pattern, text)
        return match.group(1) if match else "none"

    return {
        "rosdep": (manifest.findtext("version"), keys),
        "conda": (found(r'\n  version: "([^"]+)"', conda), set(re.findall(r"\n    - ([a-z0-9_-]+)", host))),
        "vcpkg": (port["version"], {d if isinstance(d, str) else d["name"] for d in port["dependencies"]}),
        # Reads the version of the project itself.
        "Conan": (None, set(re.findall(r'"([a-z0-9_-]+)/\[', conan))),
        "Debian": (found(r"rivid \(([0-9.]+)\)", (root / "debian/changelog").read_text()), set(re.findall(r"\n {15}([a-z0-9-]+)", debian))),
        "Homebrew": (found(r"rivid-([0-9.]+)\.tar\.gz", brew), set(re.findall(r'depends_on "([^"]+)"', brew))),
    }


def check(root: Path) -> list[str]:
    version = re.search(r"project\(rivid VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text()).group(1)
    tests_alone = re.search(r"set\(not_for_users ([^)]+)\)", (root / "cmake/RividPackages.cmake").read_text()).group(1).split()
    libraries = {p for p in (root / "packages.txt").read_text().split() if p.endswith("-dev")} - {*tests_alone, "python3-dev"}
    rows = table((root / "packaging/README.md").read_text())
    complaints = []
    if libraries != set(rows):
        complaints.append(f"packaging/README.md and packages.txt differ in {', '.join(sorted(libraries ^ set(rows)))}")
    for manager, (stated, asked) in names(root).items():
        if stated is not None and stated != version:
            complaints.append(f"the recipe for {manager} has version {stated}, the project {version}")
        for package, row in rows.items():
            name = row.get(manager, package)
            if name != "-" and name not in asked:
                complaints.append(f"the recipe for {manager} does not ask for {name} ({package})")
    return complaints


def package_xml(root: Path) -> int:
    try:
        from catkin_pkg.package import parse_package
    except ImportError:
        print("skipped: catkin_pkg is not installed in this Python (pip install catkin_pkg)")
        return SKIPPED
    warnings: list[str] = []
    package = parse_package(str(root / "package.xml"), warnings=warnings)
    package.validate(warnings=warnings)
    if warnings or package.get_build_type() != "cmake":
        print("\n".join(warnings) or f"package.xml is built by {package.get_build_type()}")
        return 1
    print(f"package.xml: {package.name} {package.version}, built by cmake")
    return 0


def main() -> int:
    root = Path(sys.argv[1])
    if "--package-xml" in sys.argv:
        return package_xml(root)
    complaints = check(root)
    print("\n".join(complaints) or "version and dependencies agree")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
