"""Pages: what they link to exists."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINK = re.compile(r"\]\(\s*<?([^)\s>]+)|<(?:img|a)\b[^>]*?(?:src|href)=\"([^\"]+)\"")


def pages():
    """The Markdown pages under version control; without git, all that are not built or hidden."""
    try:
        told = subprocess.run(
            ["git", "ls-files", "-z", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True
        )
        names = [name for name in told.stdout.split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        names = [p.relative_to(ROOT).as_posix() for p in [*ROOT.glob("*.md"), *ROOT.glob("[a-z]*/*.md")]]
    return sorted(name for name in names if (ROOT / name).is_file())


def links(text):
    """The targets of links and pictures outside code."""
    prose = re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.DOTALL)
    return [first or second for first, second in LINK.findall(prose)]


def test_links_are_found():
    """Links, pictures and HTML count; code does not."""
    text = '[a](b.md) ![c](d/e.jpg) <img src="f.png"> `[g](h)`\n```\n[i](j)\n```'
    assert links(text) == ["b.md", "d/e.jpg", "f.png"]
    assert "README.md" in pages()


@pytest.mark.parametrize("page", pages())
def test_relative_links_lead_somewhere(page):
    """Each file that a page links to or shows is there."""
    lost = [
        link
        for link in links((ROOT / page).read_text(encoding="utf-8"))
        if not re.match(r"[a-z]+:|#", link) and not ((ROOT / page).parent / link.partition("#")[0]).exists()
    ]
    assert lost == []


CODE = re.compile(r"`((?:src|core|tests|tools|docs|examples|benchmarks|web)/[\w./*-]+)(?::[\w.]+)?`")
"""A file or folder of the repository, with a name in it or without."""


def paths(text):
    """The files and folders that a page names as code, but for those with a word to be filled in: NAME."""
    named = CODE.findall(re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    return [path for path in named if not re.search(r"\b[A-Z]{2,}\b", path)]


def test_paths_are_found():
    """Files, folders and functions in files count; names to be filled in do not."""
    assert paths("`core/mpm` `src/neve/build.py:build` `core/x/NAME.hpp` `a/b`") == [
        "core/mpm",
        "src/neve/build.py",
    ]


@pytest.mark.parametrize("page", [page for page in pages() if page != "CHANGELOG.md"])
def test_paths_in_a_page_exist(page):
    """Each file and folder of the repository that a page names is there."""
    text = (ROOT / page).read_text(encoding="utf-8")
    homes = (ROOT, ROOT / "web/drive") if page == "docs/drive.md" else (ROOT,)
    lost = {path for path in paths(text) if not any(any(home.glob(path.rstrip("/"))) for home in homes)}
    made = {"core/constitutive/st_venant_kirchhoff.hpp"} if page == "examples/03_own_law.md" else set()
    assert sorted(lost - made) == []


def test_nothing_asks_for_extras_of_a_package_that_is_not_published():
    """Extras work in a checkout, as `.[film]`; elsewhere packages are asked for by their own names."""
    texts = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *(ROOT / "src/neve").rglob("*.py")]
    assert [str(path) for path in texts if "neve[" in path.read_text(encoding="utf-8")] == []
