"""C compiled while we run, for the yardsticks; the sources lie beside this file."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from vsensor.errors import VsensorError

FLAGS = ("-O3 -march=native", "-O3")
"""What the kernels are held against: all of this machine, and what a package for any machine has.
Without -ffast-math, as ours; GCC does fuse multiply and add where the machine can, ours never do."""

NO_COMPILER = "no C compiler (cc) was found here, so there is no yardstick in C and no ratio"


def compiler() -> str | None:
    """The C compiler, by the environment's CC or as `cc`; None where there is none."""
    return shutil.which(os.environ.get("CC") or "cc")


def compiler_version(cc: str) -> str:
    """The first line that a compiler says of itself."""
    said = subprocess.run([cc, "--version"], capture_output=True, text=True, check=False).stdout
    return said.partition("\n")[0] or cc


def build(cc: str, source: str, flags: str, output: Path) -> None:
    """Compile one of our C sources. Raises VsensorError with what the compiler said."""
    file = Path(__file__).with_name(source)
    command = [cc, *flags.split(), "-o", str(output), str(file), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise VsensorError(f"{' '.join(command)} failed with status {done.returncode}:\n{done.stderr}")


def library(cc: str, source: str, flags: str) -> ctypes.CDLL:
    """One of our C sources as a loaded library; its file may go once it is loaded."""
    with tempfile.TemporaryDirectory(prefix="vsensor-bench-") as folder:
        output = Path(folder) / f"{Path(source).stem}.so"
        build(cc, source, f"{flags} -shared -fPIC", output)
        return ctypes.CDLL(str(output))
