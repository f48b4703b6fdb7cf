"""What a page tells its reader to type can be typed: commands and Python are taken from the pages and run.

Runs of scenes are made short and coarse by further options. What takes minutes (benchmarks, validation,
path tracing, long examples) is read by the command's own parser and goes no further; what installs is typed
by `.ci/run`, or its extras and files are looked up.
"""

import contextlib
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tomllib
import urllib.request
from pathlib import Path

import click
import pytest
from documented import command_blocks, fenced
from patience import PATIENCE

import neve
from neve.bench.run import CASES as BENCHMARKS
from neve.cli import cli, main
from neve.validate.registry import CASES as VALIDATIONS

ROOT = Path(__file__).parents[2]

PAGES = [
    p
    for p in (
        *ROOT.glob("*.md"),
        *ROOT.glob("docs/*.md"),
        *ROOT.glob("benchmarks/*.md"),
        *ROOT.glob("examples/[!0]*.md"),  # 03_own_law.md has a test of its own
    )
]
BINARIES = Path(sys.executable).parent
SHORT = ["run.duration=0.1", "numerics.dx=0.12", "run.film=false"]
PARSE = """
import argparse, importlib.util, runpy, sys, unittest.mock
if not importlib.util.find_spec("taichi"):
    sys.modules["taichi"] = unittest.mock.MagicMock()
parse = argparse.ArgumentParser.parse_args
def parse_and_end(self, *given):
    parse(self, *given)
    sys.exit(0)
argparse.ArgumentParser.parse_args = parse_and_end
sys.argv = sys.argv[1:]
sys.path.insert(0, sys.argv[0].rpartition("/")[0])
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def commands_of(page):
    """The simple commands of a page, in order."""
    blocks = command_blocks(page.read_text(encoding="utf-8"))
    lines = [line for block in blocks for line in block if line]
    parts = [re.sub(r">.*", "", part).strip(" ()") for line in lines for part in line.split("&&")]
    return [shlex.split(part) for part in parts]


def by_id(path):
    return path.relative_to(ROOT).as_posix()


WITH_COMMANDS = [page for page in PAGES if commands_of(page)]


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """Pictures and films of runs in this process are small: drawn large they take most of a short run."""
    monkeypatch.setattr("neve.run.painter.SIZE", (160, 90))


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished run, a few coarse frames of throw_ball."""
    out = tmp_path_factory.mktemp("finished") / "ball"
    neve.Simulation(neve.load("throw_ball", SHORT)).run(out, quiet=True)
    return out


@pytest.fixture
def place(tmp_path, finished):
    """A folder to type in: a scene of one's own, the recipes, and the runs that a page takes for granted."""
    (tmp_path / "my_scene.toml").write_text(
        '[[sources]]\nshape = "sphere"\n\n[[colliders]]\nshape = "plane"\n'
    )
    for scenes in ("examples/recipes", "examples/studies"):
        shutil.copytree(ROOT / scenes, tmp_path / scenes)
    for name in ("ball", "throw_ball"):
        shutil.copytree(finished, tmp_path / "runs" / name)
    return tmp_path


def typed(words, place, **more):
    """Start a command as a shell would, with this environment's programs first on the path."""
    path = os.pathsep.join([str(BINARIES), os.environ.get("PATH", os.defpath)])
    program = shutil.which(words[0], path=path)
    assert program, f"there is no program {words[0]}"
    kinds = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, **more}
    return subprocess.Popen([program, *words[1:]], cwd=place, env={**os.environ, "PATH": path}, **kinds)


def neve_runs(words, place):
    """The command of Neve ends well: in this process, since the start of another costs as much as it."""
    code = 0
    with contextlib.chdir(place):
        try:
            main(words[1:])
        except SystemExit as end:
            code = end.code or 0
    assert code == 0, words


def runs(words, place):
    """The command ends well within a minute."""
    process = typed(words, place)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, (words, out, err)
    assert "Traceback" not in err


def run_scene(words, place):
    """`neve run`, shorter and coarser; a run of a preset's own name makes way for it."""
    if "--resume" not in words:
        shorter = [word for change in SHORT for word in ("--set", change)]
        words = [*words, *shorter, "--threads", "1", *(["--force"] if "--out" not in words else [])]
    neve_runs([*words, "--quiet"], place)


def estimate(words, place):
    """`neve estimate`, of one frame: the trial of ten seconds has tests of its own."""
    neve_runs([*words, "--frames", "1", "--threads", "1"], place)


def serve(words, place):
    """A server tells its address, answers there, and ends by Ctrl-C with exit code 0."""
    coarse = ["--set", "numerics.dx=0.12"] if words[1:] == ["view", "throw_ball"] else []
    process = typed([*words, *coarse, "--port", "0"], place, bufsize=1)
    with process:
        try:
            address = re.match(r"http://\S+?:\d+", process.stdout.readline())
            if not address:
                said = process.stderr.read()
                assert "does not carry the page" in said, said
                return "web/drive was not built before Neve was installed"
            assert urllib.request.urlopen(address[0], timeout=PATIENCE).status == 200
        finally:
            process.send_signal(signal.SIGINT)
        assert process.wait(PATIENCE) == 0
    return None


def parse_neve(words, place):
    """The command line takes these words, and knows the cases that they name."""
    with cli.make_context("neve", words[1:]) as context:
        while isinstance(context.command, click.Group):
            rest = [*context._protected_args, *context.args]
            name, command, rest = context.command.resolve_command(context, rest)
            context = command.make_context(name, rest, parent=context)
        known = {"bench": BENCHMARKS, "validate": VALIDATIONS}.get(context.info_name, ())
        assert set(context.params.get("cases", ())) <= set(known)


def parse_script(words, place):
    """A script's own parser takes these words."""
    script = next(word for word in words if word.endswith(".py"))
    command = [sys.executable, "-c", PARSE, str(ROOT / script), *words[words.index(script) + 1 :]]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr


def installs(words, place):
    """What is installed exists: the extras, and a file of requirements."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "optional-dependencies"
    ]
    for word in words[2:]:
        assert set(filter(None, re.sub(r"^[^[]*\[?|\]$", "", word).split(","))) <= set(extras)
        assert not word.endswith(".txt") or (ROOT / word).is_file()


def scripts_of_npm(words, place):
    """`npm run` names a script of web/drive."""
    scripts = json.loads((ROOT / "web/drive/package.json").read_text(encoding="utf-8"))["scripts"]
    assert words[1] != "run" or words[2] in scripts


def files_exist(words, place):
    """The files that the command names are there."""
    named = [word for word in words if "/" in word and "//" not in word and word != ".venv/bin/activate"]
    assert [word for word in named if not (ROOT / word).exists()] == []


def launched(words, place):
    """What each rank runs would run by itself."""
    what = words[words.index("-n") + 2 :]
    (parse_neve if what[0] == "neve" else parse_script)(what, place)


RULES = [
    (r"neve run ", run_scene),
    (r"neve drive .*--fit", parse_neve),
    (r"neve (view (?!.*--replay)|drive)", serve),
    (r"neve (bench|compare|validate|fuzz|render|sweep|plot)", parse_neve),
    (r"neve estimate ", estimate),
    (r"neve ", neve_runs),
    (r"python examples/\d\d_\S+\.py", files_exist),  # tests/docs/test_examples.py runs them
    (r"python (-\w )?\S+\.py", parse_script),
    (r"mpirun -n \d+ (neve|python) ", launched),
    (r"python -m venv ", files_exist),
    (r"python -m ", runs),
    (r"pip (install|wheel) ", installs),
    (r"npm ", scripts_of_npm),
    (r"(npx|pytest|cd|source|\.ci/\w+)( |$)", files_exist),
]


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=by_id)
def test_commands_of_a_page_can_be_typed(page, place):
    """Each command of the page, in their order and in one folder; none is of an unknown kind."""
    skipped = []
    for words in commands_of(page):
        rule = next((rule for pattern, rule in RULES if re.match(pattern, " ".join(words))), None)
        assert rule, f"no rule tests {words}"
        skipped.append(rule(words, place))
    if any(skipped):
        pytest.skip("; ".join(filter(None, skipped)))


def test_commands_are_found():
    """Comments go, chains and groups are taken apart, equations are no commands."""
    text = "    (cd web && npm ci)   # so\n    neve run a --set 'b={c=\"d\"}'\n\n    E = m c^2\n\n"
    text += "```sh\npytest\n```\n"
    assert command_blocks(text) == [["(cd web && npm ci)", "neve run a --set 'b={c=\"d\"}'"], ["pytest"]]
    assert {by_id(page) for page in WITH_COMMANDS} >= {"README.md", "CONTRIBUTING.md", "docs/view.md"}


def test_a_command_that_cannot_be_typed_is_found(place):
    """The rules would see a misspelled option, case, extra or file."""
    for rule, line in [
        (parse_neve, "neve bench 1mm"),
        (parse_script, "python benchmarks/view.py --sheets 1"),
        (installs, "pip install .[views]"),
        (scripts_of_npm, "npm run biuld"),
        (files_exist, "pytest tests/none"),
    ]:
        with pytest.raises(AssertionError):
            rule(line.split(), place)
    with pytest.raises(click.UsageError):
        parse_neve(["neve", "bench", "--jsn"], place)
    with pytest.raises(click.UsageError):
        parse_neve(["neve", "fuzz", "--seeds", "3"], place)


SHORTER = {'neve.load("throw_ball")': 'neve.load("throw_ball", ["numerics.dx=0.1", "run.duration=0.1"])'}
"""What makes an example short enough for a test."""
PYTHON = [(page, k) for page in PAGES for k in range(len(fenced(page.read_text(encoding="utf-8"), "python")))]


@pytest.mark.parametrize(
    ("page", "number"), PYTHON, ids=lambda v: by_id(v) if isinstance(v, Path) else str(v)
)
def test_python_of_a_page_runs(page, number, tmp_path, monkeypatch, capsys):
    """Each block of Python runs; that of the README prints what it says, and leaves a film."""
    code = fenced(page.read_text(encoding="utf-8"), "python")[number]
    for long, short in SHORTER.items():
        code = code.replace(long, short)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, by_id(page), "exec"), {})
    if page.name == "README.md":
        time, steps, *shape = capsys.readouterr().out.split(maxsplit=2)
        assert float(time) == pytest.approx(0.1)
        assert int(steps) > 0
        assert re.fullmatch(r"\(\d+, 3\)", shape[0].strip())
        assert (tmp_path / "runs/ball/preview.mp4").exists()
