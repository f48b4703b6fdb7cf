"""Do in a few minutes all that needs a GPU: compare it with the processor, test, sanitize, and measure.

    python tools/gpu/check.py --out benchmarks/results/gpu.json
    python tools/gpu/check.py --wheels wheels --out gpu.json    # on a machine without Neve: install these
    python tools/gpu/check.py --stand-in                        # a rehearsal on the processor

What is done is written after each part, so that nothing is lost if time runs out: parts that no longer fit
into --minutes are left out, and named. The first fault does not stop the rest; the exit code is 1 then.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
SANITIZED = """
import sys
sys.path.insert(0, "tests")
from gpu.runs import FLOOR, advanced, scene
ball = {"shape": "sphere", "radius": 0.2, "center": [0.2, 0, 0]}
for transfer in ("apic", "aflip"):
    advanced(scene(FLOOR, ball, transfer=transfer), "cuda")
"""


class Report:
    """Collect what was found, and write it after each part."""

    def __init__(self, out: Path | None, minutes: float) -> None:
        self.out, self.end = out, time.monotonic() + 60 * minutes
        self.found: dict[str, Any] = {"command": " ".join(sys.argv), "left_out": [], "faults": {}}

    @property
    def left(self) -> float:
        """Seconds that are left."""
        return self.end - time.monotonic()

    def part(self, name: str, needs: float, work: Callable[[], Any]) -> None:
        """Do a part if `needs` seconds are left for it."""
        if self.left < needs:
            self.found["left_out"].append(name)
            print(f"{name}: left out, {self.left:.0f} s are left", flush=True)
            return
        begun = time.monotonic()
        try:
            self.found[name] = work()
        except Exception as error:
            self.found["faults"][name] = f"{type(error).__name__}: {error}"
            traceback.print_exc()
        state = "FAULT" if name in self.found["faults"] else "done"
        print(f"{name}: {state}, {time.monotonic() - begun:.1f} s", flush=True)
        self.write()

    def write(self) -> None:
        """Write what is there."""
        if self.out:
            self.out.parent.mkdir(parents=True, exist_ok=True)
            self.out.write_text(json.dumps(self.found, indent=1) + "\n", encoding="utf-8")


def install(wheels: Path) -> Path:
    """Install wheels into a folder of their own, and Neve from this checkout if none of them is it."""
    site = Path(tempfile.mkdtemp(prefix="neve-site-"))
    pip = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-index",
        "--no-deps",
        "--target",
        str(site),
    ]
    subprocess.run([*pip, *map(str, sorted(wheels.glob("*.whl")))], check=True)
    if not list(wheels.glob("neve-*.whl")):
        subprocess.run([*pip, "--no-build-isolation", str(ROOT)], check=True, env=beside(site))
    return site


def beside(site: Path) -> dict[str, str]:
    """Return the environment of a process that finds what is installed in `site`, programs as well."""
    path = f"{site / 'bin'}{os.pathsep}{os.environ.get('PATH', '')}"
    return {**os.environ, "PYTHONPATH": str(site), "PATH": path}


def machine() -> dict[str, Any]:
    """Say on what all this was measured."""
    from neve.cuda.backend import driver

    gpu = driver()
    free, total = gpu.memory()
    git = subprocess.run(
        ["git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False
    )
    return {
        "gpu": gpu.name,
        "architecture": gpu.architecture,
        "cuda_of_driver": list(gpu.version),
        "memory_free": free,
        "memory": total,
        "commit": git.stdout.strip(),
        "date": time.strftime("%Y-%m-%d", time.gmtime()),
    }


def compiled() -> dict[str, Any]:
    """Compile the default step without the cache; say how long it takes, and what each kernel needs."""
    import ctypes

    from neve.cuda.backend import driver
    from neve.cuda.layout import step_of
    from neve.cuda.program import Choice, compiler, usage

    gpu, begun = driver(), time.monotonic()
    choice = Choice("float32", 0, 0, 8, 1, True, False)
    _, log = compiler(gpu.version).compiled(
        choice, gpu.architecture, ctypes.sizeof(step_of(choice.precision))
    )
    needs = {name: need._asdict() for name, need in usage(log).items()}
    return {"seconds": time.monotonic() - begun, "kernels": needs}


def agreement() -> dict[str, Any]:
    """Return how far GPU and processor are apart, over the largest value of each field."""
    import numpy as np
    from gpu.runs import FIELDS, FLOOR, LUMP, advanced, by_id, scene

    found = {}
    for precision in ("float32", "float64"):
        document = scene(FLOOR, source={**LUMP, "spin": [0, 20, 0]}, precision=precision)
        cpu, gpu = (advanced(document, device) for device in ("cpu", "cuda"))
        apart = {}
        for name in FIELDS:
            a, b = by_id(cpu, name), by_id(gpu, name)
            apart[name] = float(np.abs(a - b).max(initial=0.0) / max(np.abs(a).max(initial=0.0), 1e-300))
        found[precision] = {"steps": [cpu.steps, gpu.steps], **apart}
    return found


STAGES = [
    f"tests/gpu/{name}.py"
    for name in (
        "test_same_as_cpu",
        "test_bodies_on_device",
        "several/test_as_on_one",
        "test_picture",
        "test_each_preset",
    )
]
"""Tests that compare the real GPU with the processor, and a run in several domains with one in one."""
VERIFIED = ["-m", "gpu", "tests/verification"]
"""Tests with known answers, run on the GPU."""


def tests(seconds: float, which: list[str]) -> dict[str, Any]:
    """Run tests on the real GPU."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *which],
        cwd=ROOT,
        env={**os.environ, "NEVE_TEST_GPU": "1", "NEVE_TEST_DEVICE": "cuda"},
        capture_output=True,
        text=True,
        timeout=seconds,
        check=False,
    )
    lines = done.stdout.strip().splitlines()
    if done.returncode != 0:
        print(done.stdout[-4000:], done.stderr[-1000:])
        raise AssertionError(lines[-1] if lines else done.stderr[-200:])
    return {"result": lines[-1]}


def sanitized(tool: str, seconds: float) -> dict[str, Any]:
    """Run a small scene under compute-sanitizer."""
    program = shutil.which("compute-sanitizer")
    if program is None:
        return {"result": "compute-sanitizer is not installed"}
    done = subprocess.run(
        [program, "--tool", tool, "--error-exitcode", "9", sys.executable, "-c", SANITIZED],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=seconds,
        check=False,
    )
    if done.returncode != 0:
        print(done.stdout[-4000:], done.stderr[-2000:])
        raise AssertionError(f"{tool}: exit code {done.returncode}")
    return {"result": done.stdout.strip().splitlines()[-1]}


def peer(name: str, where: str, particles: str, batches: int, seconds: float) -> dict[str, Any]:
    """Run the same snow in Neve and in Taichi or Warp, in turn, on one device; their rates and ratios."""
    if importlib.util.find_spec(name) is None:
        return {"result": f"{name} is not installed"}
    program = ROOT / "benchmarks" / "peers" / "compare.py"
    wanted = ["--peer", name, "--device", where, "--particles", particles, "--batches", str(batches)]
    done = subprocess.run(
        [sys.executable, str(program), *wanted, "--json"],
        capture_output=True,
        text=True,
        timeout=seconds,
        check=False,
    )
    if done.returncode != 0:
        print(done.stdout[-2000:], done.stderr[-2000:])
        raise AssertionError(f"{name}: exit code {done.returncode}: {done.stderr[-200:]}")
    return json.loads(done.stdout[done.stdout.index("{\n") :])


@contextlib.contextmanager
def device(stand_in: bool) -> Iterator[None]:
    """Take the GPU, or plug the stand-in in."""
    sys.path[:0] = [str(ROOT / "tests"), str(Path(__file__).parent)]
    if not stand_in:
        yield
        return
    from gpu.stand_in import StandIn, build, plugged_in

    with tempfile.TemporaryDirectory() as folder, plugged_in(StandIn(build(Path(folder)))):
        yield


def check(report: Report, stand_in: bool) -> None:
    """Do all parts, in the order of what is learned from them."""
    from speeds import SIZES, TINY, fused, largest, measured

    report.part("machine", 0, machine)
    if not stand_in:
        report.part("compiled", 20, compiled)
    report.part("agreement", 10, agreement)
    sizes = TINY if stand_in else SIZES
    for name in sizes:
        report.part(f"figures {name}", 30, lambda name=name: measured(sizes[name]))
    smallest = next(iter(sizes))
    report.part(f"fused {smallest}", 30, lambda: fused(sizes[smallest]))
    if not stand_in:
        report.part("tests", 40, lambda: tests(min(90, report.left), STAGES))
        for tool in ("memcheck", "racecheck"):
            report.part(tool, 30, lambda tool=tool: sanitized(tool, min(60, report.left)))
        for name in ("taichi", "warp"):
            report.part(name, 30, lambda name=name: peer(name, "cuda", "1m", 5, min(60, report.left)))
        found = report.found.get("figures 10m")
        if found is not None:
            report.part("figures largest", 60, lambda: measured(largest(found, report.left)))
        report.part("verification", 30, lambda: tests(report.left, VERIFIED))


def main() -> int:
    """Read the arguments, install what is missing, and check."""
    arguments = argparse.ArgumentParser(description="All that needs a GPU.")
    arguments.add_argument("--out", type=Path, help="file for what is found")
    arguments.add_argument("--wheels", type=Path, help="folder of wheels to install first")
    arguments.add_argument("--minutes", type=float, default=7.5, help="time for all of it")
    arguments.add_argument("--stand-in", action="store_true", help="rehearse on the processor")
    given = arguments.parse_args()
    report = Report(given.out, given.minutes)
    if given.wheels is not None:
        site = install(given.wheels)
        rest = ["--minutes", str(report.left / 60)]
        rest += ["--out", str(given.out)] if given.out else []
        rest += ["--stand-in"] if given.stand_in else []
        line = [sys.executable, __file__, *rest]
        return subprocess.run(line, env=beside(site), check=False).returncode
    with device(given.stand_in):
        check(report, given.stand_in)
    report.write()
    print(json.dumps({name: report.found[name] for name in ("faults", "left_out")}))
    return 1 if report.found["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
