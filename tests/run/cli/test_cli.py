"""The command line: exit codes, one sentence for each mistake, JSON that parses."""

import json
import re
import subprocess
import sys
import types
from pathlib import Path

import click
import pytest

import neve
from neve.cli import console, main
from neve.scene.reading.presets import presets
from neve.scene.schema.snow_kinds import SNOWS

ROOT = Path(neve.__file__).parents[1]


@pytest.fixture
def call(capsys, tmp_path, monkeypatch):
    """Call the command line in an empty folder; return exit code, output and errors."""
    monkeypatch.chdir(tmp_path)

    def run_line(*arguments):
        with pytest.raises(SystemExit) as stop:
            main([str(argument) for argument in arguments])
        told = capsys.readouterr()
        return stop.value.code, told.out, told.err

    return run_line


def fill(folder):
    """Prepare what the bad command lines point at."""
    (folder / "full").mkdir()
    (folder / "full/letter.txt").touch()
    (folder / "broken.toml").write_text("[snow\n")
    (folder / "wrong.toml").write_text("[snow]\nxii = 3\n")
    (folder / "old").mkdir()
    (folder / "old/run.json").write_text('{"run_format": 0}')
    (folder / "old/scene.toml").write_text("")


BAD = [
    ("rum small.toml", "there is no command rum (did you mean run?)"),
    ("yodel", "there is no command yodel (the commands are "),
    ("--versoin", "there is no option --versoin (did you mean --version?)"),
    ("run", "SCENE is missing: see neve run --help"),
    ("cite", "SCENE is missing: see neve cite --help"),
    ("run small.toml --fraems 3", "there is no option --fraems (did you mean --frames?)"),
    ("run small.toml --zzz", "there is no option --zzz (the options are --out, --set,"),
    ("run small.toml --frames", "option '--frames' requires an argument"),
    ("run small.toml --frames 0", "--frames: 0 is not a whole number of 1 or more"),
    ("run small.toml --frames 1.5", "--frames: 1.5 is not a whole number of 1 or more"),
    ("run small.toml --threads -2", "--threads: -2 is not a whole number of 1 or more"),
    ("run small.toml --threads many", "--threads: many is not a whole number of 1 or more"),
    ("run small.toml other.toml", "got unexpected extra argument (other.toml)"),
    ("run small.toml --quiet=yes", "option '--quiet' does not take a value"),
    ("run smal.toml", "smal.toml: there is no such file (did you mean small.toml?)"),
    ("run throw_bal", 'no preset or file is called "throw_bal"'),
    ("run full", "full is a folder without scene.toml"),
    ("run broken.toml", "broken.toml, line 1"),
    ("run wrong.toml", "xii"),
    ("run small.toml --set snow.xy=3", "snow.xy"),
    ("run small.toml --set snow.xi", "--set snow.xi: write key=value"),
    ("run small.toml --set snow.xi=-1", "snow.xi"),
    ("run small.toml --out full", "full is not empty and is no Neve run"),
    ("run small.toml --out full --force", "--force replaces runs, never other files"),
    ("run small.toml --out small.toml", "small.toml is a file"),
    ("run small.toml --out none --resume", "none does not exist, so there is nothing to resume"),
    ("run small.toml --out full --resume", "full holds no Neve run, so there is nothing to resume"),
    ("run small.toml --out old", "continue it with --resume, replace it with --force"),
    ("run small.toml --out old --resume", "old was written by an older version of Neve"),
    ("run small.toml --out old --resume --force", "choose one of the two"),
    ("run old --resume --out other", "--resume continues in old itself: leave out --out other"),
    (f"run {'x' * 300}", "cannot be opened as a file: file name too long"),
    (f"cite {'x' * 300}", "cannot be opened as a file: file name too long"),
    (f"run {'x' * 300} --resume", "cannot be opened as a file: file name too long"),
    (f"run {'x' * 300} --out there", "cannot be opened as a file: file name too long"),
    (f"run small.toml --out {'x' * 300}", "could not be read: the name is too long"),
    ("run ~nosuchuser/x.toml", "~nosuchuser/x.toml: this cannot be opened as a file"),
    ("run text_fall --set sources.0.font=~nosuchuser/b.ttf", '"~nosuchuser/b.ttf" is not a file'),
    (f"run text_fall --set sources.0.font={'x' * 300}", "is not a file; name a .ttf or .otf file"),
    ("run small.toml --set colliders.0={shape='mesh',file='no.obj'}", 'no.obj" is not a file; name a .obj,'),
    ("run small.toml --set colliders.0={shape='mesh',file='small.toml'}", 'must end in ".obj"'),
    ("run small.toml --set colliders.0={shape='mesh',file='neve:no'}", '"neve:no" does not come with Neve'),
    ("run small.toml --threads 1000000", "--threads: 1000000 is more than "),
    (f"run small.toml --threads {'9' * 5000}", "is not a whole number of 1 or more"),
    ("cite smal.toml", "did you mean small.toml?"),
    ("list all", "got unexpected extra argument (all)"),
    ("list --jso", "there is no option --jso (did you mean --json?)"),
    ("info -x", "there is no option -x (the options are --json"),
]


@pytest.mark.parametrize(("line", "words"), BAD, ids=[line[:60] for line, _ in BAD])
def test_bad_command_lines(call, fake, scene_file, tmp_path, line, words):
    """Exit code 2, nothing on standard output, one sentence on standard error, and no folder made."""
    fill(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    code, out, err = call(*line.split())
    assert (code, out) == (2, "")
    assert words in err
    assert err.startswith("neve: ")
    assert err.count("\n") == 1
    assert not re.search(r"[.?!]\)? +[A-Z]", err), "more than one sentence"
    assert sorted(tmp_path.rglob("*")) == before


def test_bad_command_line_in_its_own_process(tmp_path):
    """The same through a real process: exit code 2 and no traceback."""
    command = [sys.executable, "-m", "neve.cli", "run", "nowhere.toml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


def test_run_writes_where_it_says(call, fake, scene_file, tmp_path):
    """Without --out the run goes to runs/NAME; plain lines tell how it goes when there is no terminal."""
    code, out, err = call("run", "small.toml")
    assert (code, out) == (0, "")
    assert (tmp_path / "runs/small/frames/000008.npz").exists()
    lines = err.splitlines()
    assert lines[0] == "small: frame 0 of 8, 50 particles"
    assert re.fullmatch(r"small: frame 8 of 8, 50 particles, [\d,.e+]+ steps/s", lines[-2])
    assert lines[-1].startswith("runs/small: frames 0 to 8 are done")


def test_quiet_says_nothing(call, fake, scene_file):
    """--quiet leaves only warnings and errors, and a run in order has none."""
    assert call("run", "small.toml", "--quiet", "--out", "there") == (0, "", "")


def test_quiet_hides_no_warning(call, scene_file, tmp_path):
    """A fixed step that waves outrun once the snow is pressed is told, --quiet or not: the real simulation.

    dx = 0.1 m, c = 19.7 m/s at rest, |v| = 9 m/s: up to 3.48 ms the scene is beyond doubt. On the floor snow
    hardens by exp(xi (1 - J_P)), and its waves cross a cell sooner than in 3 ms.
    """
    path = tmp_path / "ball.toml"
    path.write_text(
        "[numerics]\ndx = 0.1\ndt = 3e-3\n[run]\nduration = 0.1\nfilm = false\n[snow]\nxi = 20.0\n"
        '[[sources]]\nshape = "sphere"\ncenter = [0, 0, 0.25]\nradius = 0.2\nvelocity = [0, 0, -9]\n'
        '[[colliders]]\nshape = "plane"\n'
    )
    code, out, err = call("run", path, "--out", "a", "--threads", 1, "--quiet")
    assert (code, out) == (0, "")
    assert err.startswith("neve: warning: ")
    told = [line for line in err.splitlines() if "numerics.dt = 0.003 s is beyond the limit" in line]
    assert len(told) == 1
    assert all(line.startswith("neve: warning: ") for line in err.splitlines())
    code, _, err = call("run", path, "--out", "b", "--threads", 1)
    assert told[0].removeprefix("neve: ") in err.splitlines()


def test_run_options_reach_the_run(call, fake, scene_file, tmp_path, monkeypatch):
    """--set, --frames and --threads arrive."""
    seen = []
    real = fake.Simulation.__init__

    def watched(self, scene, threads):
        seen.append(threads)
        real(self, scene, threads)

    monkeypatch.setattr(fake.Simulation, "__init__", watched)
    assert call("run", "small.toml", "--set", "snow.xi=12", "--frames", 2, "--threads", 3, "--quiet")[0] == 0
    assert seen == [3]
    assert "xi = 12.0" in (tmp_path / "runs/small/scene.toml").read_text()
    assert len(list((tmp_path / "runs/small/frames").iterdir())) == 3


def test_a_run_folder_is_a_scene(call, fake, scene_file, tmp_path):
    """A run folder runs again into another folder to the same bytes, and goes on in itself with --resume."""
    assert call("run", "small.toml", "--out", "a", "--frames", 2, "--quiet")[0] == 0
    assert call("run", "a", "--out", "b", "--quiet")[0] == 0
    assert call("run", "a", "--resume", "--quiet")[0] == 0
    files = [sorted(p.read_bytes() for p in (tmp_path / out / "frames").iterdir()) for out in "ab"]
    assert files[0] == files[1]
    assert len(files[0]) == 9


def test_a_run_folder_with_a_dot_keeps_its_name(call, fake, scene_file, tmp_path):
    """A folder has no suffix: ball.v2 runs again into runs/ball.v2."""
    assert call("run", "small.toml", "--out", "ball.v2", "--frames", 1, "--quiet")[0] == 0
    assert call("run", "ball.v2", "--frames", 1, "--quiet")[0] == 0
    assert (tmp_path / "runs/ball.v2/run.json").exists()


def test_a_run_folder_is_replaced_by_itself(call, fake, scene_file, tmp_path):
    """--force reads the scene before it clears the folder that holds it."""
    assert call("run", "small.toml", "--out", "a", "--frames", 2, "--quiet")[0] == 0
    assert call("run", "a", "--out", "a", "--force", "--frames", 1, "--quiet")[0] == 0
    assert len(list((tmp_path / "a/frames").iterdir())) == 2


@pytest.mark.parametrize(
    ("stop", "words"),
    [
        (KeyboardInterrupt("after frame 3"), "after frame 3"),
        (KeyboardInterrupt(), "stopped"),
        (click.Abort(), "stopped"),
    ],
)
def test_ctrl_c_anywhere_is_130(call, fake, scene_file, monkeypatch, stop, words):
    """Ctrl-C before, in and after the loop ends with 130 and a word, not with a traceback."""

    def interrupted(*_, **__):
        raise stop

    monkeypatch.setattr(fake.Simulation, "__init__", interrupted)
    code, _, err = call("run", "small.toml")
    assert code == 130
    assert err.strip() == f"neve: {words}"


def test_errors_of_the_simulation(call, fake, scene_file, monkeypatch):
    """A particle without numbers and too little memory are sentences; a mistake in Neve is none."""
    failures = types.ModuleType("neve.solver")
    failures.Blowup = type("Blowup", (RuntimeError,), {})
    monkeypatch.setitem(sys.modules, "neve.solver", failures)

    def failing(error):
        def fail(*_, **__):
            raise error

        return fail

    monkeypatch.setattr(fake.Simulation, "advance", failing(failures.Blowup("particle 7 lost its numbers.")))
    code, _, err = call("run", "small.toml", "--out", "a", "--quiet")
    assert (code, err) == (2, "neve: particle 7 lost its numbers.\n")
    monkeypatch.setattr(fake.Simulation, "advance", failing(MemoryError()))
    code, _, err = call("run", "small.toml", "--out", "b", "--quiet")
    assert (code, "more memory than the machine has" in err) == (2, True)
    refused = PermissionError(13, "Permission denied", "a/place")
    monkeypatch.setattr(fake.Simulation, "advance", failing(refused))
    code, _, err = call("run", "small.toml", "--out", "d", "--quiet")
    assert (code, err) == (2, "neve: a/place: permission is denied.\n")
    monkeypatch.setattr(fake.Simulation, "advance", failing(RuntimeError("a bug")))
    with pytest.raises(RuntimeError, match="a bug"):
        main(["run", "small.toml", "--out", "c", "--quiet"])


def test_list(call):
    """Every preset has a line; the JSON holds the same."""
    code, out, _ = call("list")
    assert (code, [line.split()[0] for line in out.splitlines()]) == (0, presets())
    code, out, _ = call("list", "--json")
    entries = json.loads(out)
    assert [entry["name"] for entry in entries] == presets()
    assert all(entry["about"] for entry in entries)


def test_list_of_snows(call):
    """Every named snow begins a line, and every tag; the JSON holds the same."""
    code, out, _ = call("list", "--snow")
    lines = [line.split()[0] for line in out.splitlines() if line[:1].strip()]
    assert (code, lines) == (0, [*SNOWS, "quoted", "derived", "chosen"])
    entries = json.loads(call("list", "--snow", "--json")[1])
    assert [entry["name"] for entry in entries] == list(SNOWS)
    slush = entries[list(SNOWS).index("slush")]
    assert (slush["law"], slush["constants"]["M"]) == ("cam_clay", SNOWS["slush"].constants["M"])


def test_warnings_of_a_scene(call, scene_file, fake):
    """A doubtful scene is told on standard error, a line each, and runs; `--quiet` keeps them."""
    doubtful = ["run", scene_file, "--set", "numerics.dx=0.5", "--frames", "1"]
    code, _, told = call(*doubtful, "--out", "a")
    assert code == 0
    warned = [line for line in told.splitlines() if line.startswith("neve: warning: sources.0.")]
    assert len(warned) == 1
    assert warned[0].endswith(" or smaller.")
    code, _, told = call(*doubtful, "--out", "b", "--quiet")
    assert (code, told.splitlines()) == (0, warned)


def test_warnings_of_building(call, tmp_path):
    """What is found only when the scene is built is told once, also with --quiet: the real simulation."""
    path = tmp_path / "ball.toml"
    path.write_text(
        "[numerics]\ndx = 0.1\n[run]\nduration = 0.01\nfps = 100\nfilm = false\n"
        '[[sources]]\nshape = "sphere"\ncenter = [0, 0, 0.2]\nradius = 0.4\n[[colliders]]\nshape = "plane"\n'
    )
    code, out, err = call("run", path, "--out", "a", "--threads", 1, "--quiet")
    assert (code, out) == (0, "")
    assert re.fullmatch(
        r"neve: warning: sources\.0 starts with \d+ inside colliders\.0, of \d+ particles: they are left "
        r"out\.\n",
        err,
    )


def test_info(call):
    """Version, instruction set and threads, as text and as JSON."""
    code, out, _ = call("info", "--json")
    facts = json.loads(out)
    assert code == 0
    assert {"version", "python", "platform", "simd", "threads"} <= facts.keys()
    assert f"version: {facts['version']}" in call("info")[1].splitlines()


def test_info_of_the_cache(call, tmp_path, monkeypatch):
    """The folder of the cache and its size stand in the facts; it need not exist, and may be switched off."""
    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "cache"))
    facts = json.loads(call("info", "--json")[1])
    assert (facts["cache"], facts["cache_bytes"]) == (str(tmp_path / "cache"), 0)
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache/a.npz").write_bytes(b"x" * 2**20)
    lines = call("info")[1].splitlines()
    assert f"cache: {tmp_path / 'cache'}" in lines
    assert "cache_size: 1.0 MB" in lines
    monkeypatch.setenv("NEVE_CACHE", "")
    assert "cache: off" in call("info")[1].splitlines()


def test_bench_passes_its_words_on(call, monkeypatch):
    """The cases, --json and --compare reach the benchmarks."""
    seen = []
    monkeypatch.setattr("neve.bench.run.run", lambda *words: seen.append(words))
    assert call("bench", "step_20k", "--json")[0] == 0
    assert call("bench", "--compare", "before.csv")[0] == 0
    assert seen == [(["step_20k"], True, None), ([], False, "before.csv")]


def test_python_m_neve_is_neve():
    """The same command line, its exit codes included."""
    done = [
        subprocess.run([sys.executable, "-m", "neve", *words], capture_output=True, text=True, check=False)
        for words in (["--version"], ["--versoin"])
    ]
    assert [d.returncode for d in done] == [0, 2]
    assert done[0].stdout.startswith("neve ")
    assert "did you mean --version?" in done[1].stderr


def test_version_and_help(call):
    """--version, --help and no word at all end with 0."""
    code, out, _ = call("--version")
    assert code == 0
    assert out == f"neve {neve.__version__}\n"
    for words in ([], ["--help"], ["run", "--help"], ["-h"]):
        code, out, err = call(*words)
        assert (code, err) == (0, "")
        assert out.startswith("Usage: neve")


def test_command_line_loads_little():
    """Beyond what `import neve` loads, the command line loads only click."""
    code = (
        "import sys, json, neve; before = set(sys.modules); import neve.cli;"
        "print(json.dumps(sorted({n.partition('.')[0] for n in set(sys.modules) - before})))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(json.loads(out.stdout)) - set(sys.stdlib_module_names)
    assert loaded <= {"neve", "click", "colorama"}
    assert "click" in loaded


def test_user_errors_are_where_they_are_said_to_be():
    """The names of the errors that become sentences exist."""
    for module, name in console.USER_ERRORS:
        assert issubclass(getattr(__import__(module, fromlist=[name]), name), Exception)
