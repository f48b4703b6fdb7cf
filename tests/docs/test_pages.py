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
