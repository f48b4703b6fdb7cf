"""Pages: what they link to exists, and the first example of the README runs."""

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


def test_example_of_the_readme_runs(tmp_path, monkeypatch, capsys):
    """The first block of Python in the README, coarser and for one frame, does what it says."""
    code = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)[1]
    changes = {
        'neve.load("throw_ball")': 'neve.load("throw_ball", ["numerics.dx=0.1"])',
        'sim.run(out="runs/ball")': 'sim.run(out="runs/ball", frames=1, quiet=True)',
    }
    for old, new in changes.items():
        assert code.count(old) == 1
        code = code.replace(old, new)
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    time, steps, *shape = capsys.readouterr().out.split(maxsplit=2)
    assert float(time) > 0.0
    assert int(steps) > 0
    assert re.fullmatch(r"\(\d+, 3\)", shape[0].strip())
    assert (tmp_path / "runs/ball/preview.mp4").exists()
