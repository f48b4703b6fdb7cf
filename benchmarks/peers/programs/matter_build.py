"""Build Matter with our set-up of the block: `matter_build.py FOLDER`.

The source is cloned from the repository that the variable MATTER_SOURCE names, by default its authors'. Eigen
must be installed. Matter is under the GPL 3, and so is the program that this builds; it goes to no one else.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
SOURCE = "https://github.com/larsblatny/matter"
EIGEN = "/usr/include/eigen3"  # or where the variable EIGEN_INCLUDE says
LEFT_OUT = {"save_data.cpp"}  # it writes files, by a library that its build downloads


def main() -> None:
    """Clone and compile."""
    folder = Path(sys.argv[1]) / "matter"
    source = os.environ.get("MATTER_SOURCE", SOURCE)
    subprocess.run(["git", "clone", "--quiet", "--depth", "1", source, folder], check=True)
    eigen = os.environ.get("EIGEN_INCLUDE", EIGEN)
    if not Path(eigen).is_dir():
        raise SystemExit("Error: the headers of Eigen 3 are not installed")
    files = [path for path in (folder / "src/simulation").glob("*.cpp") if path.name not in LEFT_OUT]
    flags = ["-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-fopenmp", "-DTHREEDIM", '-DSRC_DIR=""', "-w"]
    include = [f"-I{folder / 'src'}", f"-I{eigen}"]
    sources = [str(HERE / "matter_snow.cpp"), *map(str, sorted(files))]
    compiler, program = os.environ.get("CXX", "g++"), str(folder.parent / "matter_snow")
    subprocess.run([compiler, *flags, *include, *sources, "-o", program], check=True)


if __name__ == "__main__":
    main()
