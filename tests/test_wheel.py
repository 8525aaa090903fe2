"""The built wheel works by itself: data, command, validation."""

from __future__ import annotations

import os
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from mrm_mtlx import __version__

REPOSITORY = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(REPOSITORY)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


def test_the_wheel_has_the_version_of_the_package(wheel: Path) -> None:
    assert wheel.name == f"mrm_mtlx-{__version__}-py3-none-any.whl"


def test_the_wheel_carries_the_data(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    for folder in ("libraries", "materials", "materials_classes"):
        files = {p.relative_to(REPOSITORY).as_posix() for p in (REPOSITORY / folder).rglob("*") if p.is_file()}
        assert {f"mrm_mtlx/data/{name}" for name in files} <= names
    assert "mrm_mtlx/py.typed" in names
    standards = {p.relative_to(REPOSITORY).as_posix() for p in (REPOSITORY / "mrm_mtlx/standards/data").iterdir()}
    assert len(standards) == 3
    assert standards <= names
    schemas = {p.relative_to(REPOSITORY).as_posix() for p in (REPOSITORY / "mrm_mtlx/formats/gltf").glob("*.json")}
    assert len(schemas) == 2
    assert schemas <= names


@pytest.mark.large
def test_the_wheel_works_in_a_fresh_environment(wheel: Path, tmp_path: Path) -> None:
    venv.create(tmp_path / "venv", with_pip=True)
    bin_folder = tmp_path / "venv" / "bin"
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}

    def run(*command: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(bin_folder / command[0]), *command[1:]],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )

    # What it depends on comes from the environment of the tests; .ci/run installs all of it anew.
    (site,) = (tmp_path / "venv" / "lib").glob("python*/site-packages")
    (site / "dependencies.pth").write_text("\n".join(path for path in sys.path if "site-packages" in path))
    pip = ("python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
    installed = run(*pip, "--no-deps", "--ignore-installed", str(wheel))
    assert installed.returncode == 0, installed.stderr
    assert run("mrm", "doctor").returncode in (0, 1)  # 1 where this machine has no OpenGL
    materials = run("mrm", "library", "--materials").stdout.strip()
    assert Path(materials).is_relative_to(tmp_path.resolve())
    checked = run("mrm", "validate", f"{materials}/licence_plate.mtlx", "--target", "glsl", "--samples", "1024")
    assert checked.returncode in (0, 3), checked.stdout + checked.stderr  # 3 where this machine has no OpenGL
    assert "licence_plate.mtlx" in checked.stdout
