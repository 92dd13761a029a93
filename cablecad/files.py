"""Output that appears whole or not at all: written aside, then renamed over its target.

The file aside is called ``.NAME.N.tmp`` and lies in the target's folder, for only within a file system is a rename one
step. It is locked while its process lives, so that what a killed process left behind can be told from what another is
writing (a process number could not: containers share folders but not numbers), and the next that writes the same
target removes it. Whoever renames last wins; no reader and no kill at any moment sees half a file.

What cannot be renamed over (a device such as /dev/stdout, a named pipe) is written straight. A symbolic link stays, and
what it points to is replaced.
"""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
import time
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

from cablecad.errors import ExchangeError

if sys.platform != "win32":
    import fcntl

_LONGEST_STEM = 60
"""Characters of the target's name in the name aside: in UTF-8 at most 240 of the 255 bytes a name may have."""

_STALE_AFTER = 86400.0
"""Where files are not locked (Windows), one aside that has not been touched for a day is nobody's [s]."""

_REMEDIES = {
    errno.ENOENT: "its folder does not exist; create it, or check the path",
    errno.ENOTDIR: "a part of its path is a file, not a folder; check the path",
    errno.EACCES: "that is not permitted; check the permissions of the file and of its folder, or write elsewhere",
    errno.EPERM: "that is not permitted; check the permissions of the file and of its folder, or write elsewhere",
    errno.EROFS: "the file system is read-only; write elsewhere",
    errno.ENOSPC: "no space is left on the device; free some, or write elsewhere",
    errno.EDQUOT: "the disk quota is used up; free some, or write elsewhere",
    errno.EFBIG: "it would be larger than the file system or a limit allows; write elsewhere",
    errno.ENAMETOOLONG: "its name is too long; choose a shorter one",
    errno.ELOOP: "its symbolic links go round in a circle; mend them",
    errno.EISDIR: "it is a folder; give the name of a file",
    errno.EPIPE: "whoever was reading it has gone",
}


@contextmanager
def replacing(path: str | PathLike[str]) -> Iterator[Path]:
    """Give a path to write to, which becomes `path` when the block ends, and vanishes when it raises.

    The file keeps the permissions of the one it replaces; a new one gets those any new file gets.

    Args:
        path: The target.

    Yields:
        An empty file in the target's folder; or the target itself, where it is a device or a pipe.

    Raises:
        ExchangeError: The target cannot be written: it is a folder, its folder is missing or not writable, there is
            no space; also for such errors of the block itself. All other exceptions pass.
    """
    shown = os.fspath(path)
    aside = _Aside()
    try:
        with explained(shown):
            found = _target(shown)
            place = Path(shown) if found is None else aside.open(*found)
        with explained(shown, {shown, str(place)}):
            yield place
            if found is not None:
                target, status = found
                _settle(place, status)
                place.replace(target)
    except BaseException:
        aside.remove()
        raise
    finally:
        aside.close()


def write_bytes(path: str | PathLike[str], data: bytes) -> None:
    """Write a file whole or not at all.

    Raises:
        ExchangeError: As `replacing`.
    """
    with replacing(path) as aside, aside.open("wb") as file:
        file.write(data)


def remove_leftovers(path: str | PathLike[str]) -> None:
    """Remove what killed processes left of their writing of a file; what a living one writes stays."""
    target, n = Path(os.path.realpath(path)), 0
    while _remove_stale(_aside(target, n)):
        n += 1


def same_file(one: str | PathLike[str], other: str | PathLike[str]) -> bool:
    """Whether two paths lead to one file, by links of either kind too; for files that do not exist yet, by name."""
    try:
        return Path(one).samefile(other)
    except (OSError, ValueError):
        return os.path.normcase(os.path.realpath(one)) == os.path.normcase(os.path.realpath(other))


@contextmanager
def explained(shown: str, ours: Collection[str] | None = None) -> Iterator[None]:
    """Turn the system's errors into ours, with a remedy; if `ours` is given only those about its files, or about none.

    Raises:
        ExchangeError: In place of an OSError.
    """
    try:
        yield
    except ExchangeError:
        raise
    except OSError as error:
        if ours is not None and error.filename is not None and str(error.filename) not in ours:
            raise
        remedy = _REMEDIES.get(error.errno or 0, f"{error.strerror or error}; check the path, or write elsewhere")
        raise ExchangeError(f"{shown} cannot be written: {remedy}") from error


def _target(shown: str) -> tuple[Path, os.stat_result | None] | None:
    """The file to replace, links followed, and its status if it exists; None where it is to be written straight."""
    if not shown or shown.endswith((os.sep, os.altsep or os.sep)):
        raise ExchangeError(f"{shown!r} cannot be written: it names a folder; give the name of a file")
    if "\0" in shown:
        raise ExchangeError(f"{shown!r} cannot be written: a path must not hold a null character")
    # These name open files of this process, which may be ordinary files: one that was replaced would take what the
    # process still writes along into oblivion.
    if str(Path(shown).absolute()).startswith(("/dev/stdout", "/dev/stderr", "/dev/fd/", "/proc/")):
        return None
    target = Path(os.path.realpath(shown))
    try:
        status = Path(shown).stat()
    except FileNotFoundError:
        return target, None
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), shown)
    if not stat.S_ISREG(status.st_mode):
        return None
    # A rename would not ask whether the file may be written.
    if not os.access(shown, os.W_OK, effective_ids=os.access in os.supports_effective_ids):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), shown)
    return target, status


class _Aside:
    """A file beside a target that is ours while its descriptor is open.

    Ctrl-C may come between any two steps: each is noted before it is done, so that nothing is left behind.
    """

    def __init__(self) -> None:
        self._tried: Path | None = None
        self._handle: int | None = None

    def open(self, target: Path, status: os.stat_result | None) -> Path:
        """Make a new file beside `target`, of which `status` is known if it exists."""
        n = 0
        while True:
            aside = _aside(target, n)
            n += 1
            _remove_stale(aside)
            self._tried = aside
            try:
                # What replaces a private file is private from the start.
                mode = 0o666 if status is None else 0o600
                self._handle = os.open(aside, os.O_CREAT | os.O_EXCL | os.O_RDWR, mode)
            except FileExistsError:  # another is writing it
                continue
            if sys.platform == "win32":  # which renames no file that is open
                self.close()
                return aside
            if _lock(self._handle) and _is_at(aside, self._handle):
                break
            self.close()  # another took the file for stale before it was locked, and has removed it or is about to
        while _remove_stale(_aside(target, n)):  # of earlier times when several wrote at once
            n += 1
        return aside

    def remove(self) -> None:
        """Remove the file, if there is one of ours."""
        if self._tried is None:
            return
        if self._handle is None and sys.platform != "win32":
            _remove_stale(self._tried)  # nobody's, unless another has locked it
            return
        with contextlib.suppress(OSError):
            self._tried.unlink()

    def close(self) -> None:
        """Let go of the file, and of its lock."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def _aside(target: Path, n: int) -> Path:
    return target.with_name(f".{target.name[:_LONGEST_STEM]}.{n}.tmp")


def _settle(aside: Path, status: os.stat_result | None) -> None:
    """Bring the contents to the disk, as the rename must not get there before them, and give old permissions."""
    with aside.open("rb+") as file:
        os.fsync(file.fileno())
    if status is not None and sys.platform != "win32":
        with contextlib.suppress(PermissionError):  # only root gives files away, and a group one is not in is no loss
            os.chown(aside, status.st_uid, status.st_gid)
        aside.chmod(stat.S_IMODE(status.st_mode) & 0o777)


if sys.platform == "win32":

    def _remove_stale(aside: Path) -> bool:
        """Remove a file aside that nobody has touched for a day; whether one was removed."""
        try:
            if time.time() - aside.stat().st_mtime < _STALE_AFTER:
                return False
            aside.unlink()
        except OSError:
            return False
        return True

else:

    def _lock(handle: int) -> bool:
        """Whether the file could be locked, or its file system has no locks."""
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:  # no locks here: nobody will take it for stale either
            return True
        return True

    def _is_at(aside: Path, handle: int) -> bool:
        """Whether the path still leads to the open file."""
        try:
            return os.path.samestat(aside.lstat(), os.fstat(handle))
        except FileNotFoundError:
            return False

    def _remove_stale(aside: Path) -> bool:
        """Remove a file aside whose process is gone, for the lock went with it; whether one was removed."""
        try:
            handle = os.open(aside, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
        except OSError:
            return False
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not _is_at(aside, handle):
                return False
            aside.unlink()
        except OSError:  # locked: it lives
            return False
        finally:
            os.close(handle)
        return True
