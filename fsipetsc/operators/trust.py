"""Whether a folder can be trusted with code: nobody but its user, and root, can have put something there.

numba keeps compiled kernels as pickles, and whoever can write a pickle runs code in the process that loads it. The rules
are those of OpenSSH for a user's keys (sshd_config(5), StrictModes), and that a folder with the sticky bit may be open.
"""

from __future__ import annotations

import grp
import os
import pwd
import stat
from pathlib import Path


def trusted(folder: Path) -> bool:
    """Whether `folder` and the folders above it, up to the home directory or the root, are closed to others.

    All belong to this user or to root. None can be written by others; those above may be open if they have the sticky
    bit, so that only the owner of an entry can replace it. Raises OSError if one cannot be looked at.
    """
    real = Path(os.path.realpath(folder))
    home = os.path.realpath(os.path.expanduser("~"))
    if not _closed(real, shared=False):
        return False
    if str(real) == home:
        return True
    for parent in real.parents:
        if not _closed(parent, shared=True):
            return False
        if str(parent) == home:
            break
    return True


def content_trusted(folder: Path) -> bool:
    """Whether nobody else has put or changed anything in `folder`: it may have been open to others before."""
    entered = folder.stat().st_mode & 0o077  # else what lies inside could not be reached, whatever its own mode is
    for path in folder.rglob("*"):
        try:
            status = path.lstat()
        except FileNotFoundError:  # another process tidies up
            continue
        if stat.S_ISLNK(status.st_mode) or status.st_uid not in (0, os.getuid()):
            return False
        if entered and not _kept_from_others(status):
            return False
    return True


def _closed(folder: Path, shared: bool) -> bool:
    """Whether one folder, for itself, is closed to others; shared: with the sticky bit it may be open."""
    status = folder.stat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid not in (0, os.getuid()):
        return False
    return bool(shared and status.st_mode & stat.S_ISVTX) or _kept_from_others(status)


def _kept_from_others(status: os.stat_result) -> bool:
    """Whether the mode lets only the owner write."""
    by_group = status.st_mode & stat.S_IWGRP and not _group_of_one(status.st_gid)
    return not (by_group or status.st_mode & stat.S_IWOTH)


def _group_of_one(gid: int) -> bool:
    """Whether nobody else is in the group: many systems give each user one, and let it write what the user makes."""
    try:
        user, group = pwd.getpwuid(os.getuid()), grp.getgrgid(gid)
    except KeyError:
        return False
    return gid == 0 or (gid == user.pw_gid and group.gr_name == user.pw_name and set(group.gr_mem) <= {user.pw_name})
