"""A constant force on a gas, in plain Python and a process of its own: plain_gravity.py."""

from helpers import REPOSITORY, run


def test_in_plain_python(tmp_path):
    here = "-p", "no:cacheprovider", "-c", REPOSITORY / "pyproject.toml"
    done = run("-m", "pytest", "-q", *here, REPOSITORY / "tests" / "plain_gravity.py", cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
