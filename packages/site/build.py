#!/usr/bin/env python3
"""The documents as a site: build.py OUT [--repository URL]; needs requirements.txt beside it.

README.md is the first page, and the pages stand in the order of docs/README.md. The files that a page leads to are in the
site, too, so that it is read without a network. A link or an anchor that leads nowhere ends it with status 1.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")


def links(page: Path) -> list[tuple[str, Path]]:
    """What a page leads to in this repository: the text of each link, and the file."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    found = [(words, target.split("#")[0]) for words, target in LINK.findall(text) if "://" not in target]
    return [(words, (page.parent / target).resolve()) for words, target in found if target]


def files_of_the_site() -> set[Path]:
    """README.md, and all that it leads to."""
    found, open_pages = set(), [ROOT / "README.md"]
    while open_pages:
        page = open_pages.pop()
        if page in found:
            continue
        if not page.is_relative_to(ROOT) or not page.is_file():
            sys.exit(f"{page}: a page leads there, and there is no such file")
        found.add(page)
        if page.suffix == ".md":
            open_pages += [file for _, file in links(page)]
    return found


def order() -> list[dict]:
    """The navigation: the sections of docs/README.md, each with the pages that it lists."""
    overview = ROOT / "docs/README.md"
    sections: list[dict] = [{"Start": "README.md"}]
    listed = set()
    head, *parts = re.split(r"^## (.*)$", overview.read_text(encoding="utf-8"), flags=re.MULTILINE)
    for title, body in zip(parts[::2], parts[1::2], strict=True):
        pages = []
        for words, target in LINK.findall(body):
            page = (overview.parent / target.split("#")[0]).resolve()
            if page.suffix == ".md" and page not in listed:
                listed.add(page)
                title_of = words.replace("`", "")
                pages.append({title_of[0].upper() + title_of[1:]: str(page.relative_to(ROOT))})
        sections.append({title: pages})
    sections.append({"All documents": "docs/README.md"})
    return sections


def main() -> int:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("out", type=Path)
    arguments.add_argument("--repository", help="the address of the repository, for a link on each page")
    options = arguments.parse_args()

    with tempfile.TemporaryDirectory() as work:
        pages = Path(work, "pages")
        for file in files_of_the_site():
            copy = pages / file.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, copy)
        settings = {
            "site_name": "profidrive",
            "docs_dir": "pages",
            "site_dir": "site",
            "nav": order(),
            # No font and no script from elsewhere.
            "theme": {"name": "material", "font": False, "features": ["navigation.indexes", "navigation.top", "content.code.copy"]},
            "plugins": ["search"],
            "markdown_extensions": [
                "tables",
                "sane_lists",
                "pymdownx.superfences",
                "pymdownx.highlight",
                # Anchors as the pages of the repository have them.
                {"toc": {"permalink": True, "slugify": "!slugify"}},
            ],
            "validation": {"omitted_files": "info", "links": {"not_found": "warn", "anchors": "warn", "unrecognized_links": "warn"}},
        }
        if options.repository:
            settings["repo_url"] = options.repository
        text = yaml.safe_dump(settings, allow_unicode=True, sort_keys=False)
        slugify = "!!python/object/apply:pymdownx.slugs.slugify {kwds: {case: lower}}"
        Path(work, "mkdocs.yml").write_text(text.replace("'!slugify'", slugify), encoding="utf-8")
        command = [sys.executable, "-m", "zensical", "build", "--strict", "--config-file", "mkdocs.yml"]
        if subprocess.run(command, cwd=work).returncode != 0:
            return 1
        shutil.copytree(Path(work, "site"), options.out, dirs_exist_ok=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
