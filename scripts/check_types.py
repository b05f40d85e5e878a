"""Check the types of weavesim and of the scenes with mypy: make lint.

In a checkout, scenes/ is next to weavesim/ but is imported as a package inside it, which mypy cannot know. So mypy gets
a folder of links with the layout of the imports. Kernels are excluded: mypy cannot follow Warp's dialect.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def main() -> int:
    """Run mypy and return its exit code."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "weavesim"
        package.mkdir()
        for path in [*(ROOT / "weavesim").iterdir(), ROOT / "scenes"]:
            (package / path.name).symlink_to(path)
        command = [sys.executable, "-m", "mypy", "--config-file", str(ROOT / "pyproject.toml")]
        command += ["--cache-dir", str(ROOT / ".mypy_cache"), *sys.argv[1:]]
        return subprocess.run(command, cwd=folder, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
