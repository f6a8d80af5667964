"""Opens pages of the built site on disk in Chromium: site.py SITE CHROMIUM. Its search finds pages, and formulas are typeset."""

import html
import pathlib
import re
import subprocess
import sys
import tempfile


def opened(chromium, address):
    """The page as it is once its scripts have run."""
    with tempfile.TemporaryDirectory() as profile:
        command = [chromium, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}", "--dump-dom",
                   "--virtual-time-budget=20000", address]
        return subprocess.run(command, check=True, capture_output=True, text=True, timeout=120).stdout


def main():
    site, chromium = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
    found = re.findall(r'href="([^"]*)" class="md-search-result__link"', opened(chromium, f"{site.as_uri()}/index.html?q=payload"))
    if not any("payload.html" in html.unescape(link) for link in found):
        return f"the search finds {found} for payload"
    if not (site / "katex").is_dir():
        print("skipped: the site has no KaTeX")
        return 0
    for page in sorted(site.glob("*.html")):
        formulas = page.read_text(encoding="utf-8").count('class="arithmatex"')
        text = opened(chromium, page.as_uri()) if formulas else ""
        if text.count('class="katex"') != formulas or "katex-error" in text:
            return f"{page.name}: not all of its {formulas} formulas are typeset"
    return 0


if __name__ == "__main__":
    sys.exit(main())
