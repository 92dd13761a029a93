"""Output is whole or not at all: whatever is killed, interrupted, full or forbidden."""

import os
import random
import resource
import signal
import stat
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import pytest

from cablecad.errors import ExchangeError
from cablecad.files import replacing, same_file, write_bytes

HOLD = """
import sys
from cablecad.files import replacing
with replacing(sys.argv[1]) as aside:
    aside.write_bytes(b"other")
    print(aside, flush=True)
    sys.stdin.readline()
"""

WRITE_FOR_EVER = """
import sys
from cablecad.files import write_bytes
letters, size = sys.argv[2].encode(), int(sys.argv[3])
print("ready", flush=True)
while True:
    for letter in letters:
        write_bytes(sys.argv[1], bytes([letter]) * size)
"""


def python(code, *arguments, **options):
    """A process of its own that runs `code`."""
    return subprocess.Popen([sys.executable, "-c", code, *map(str, arguments)], stdout=subprocess.PIPE, **options)


def names(folder):
    return sorted(path.name for path in folder.iterdir())


# --- the ordinary way -----------------------------------------------------------------------------------------------


def test_new_file_and_replaced_file(tmp_path):
    target = tmp_path / "größe 中.step"
    write_bytes(target, b"one")
    assert target.read_bytes() == b"one"
    write_bytes(str(target), b"two")
    assert target.read_bytes() == b"two"
    assert names(tmp_path) == [target.name]


def test_target_is_untouched_until_the_block_ends(tmp_path):
    target = tmp_path / "out.step"
    target.write_bytes(b"old")
    with replacing(target) as aside:
        aside.write_bytes(b"new")
        assert aside.parent == tmp_path
        assert aside.name.startswith(".out.step.")
        assert target.read_bytes() == b"old"
    assert target.read_bytes() == b"new"
    assert not aside.exists()


def test_relative_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_bytes("out.step", b"data")
    assert (tmp_path / "out.step").read_bytes() == b"data"


@pytest.mark.parametrize("length", [61, 200, 250, 255])
@pytest.mark.parametrize("letter", ["a", "é"])
def test_longest_names(tmp_path, letter, length):
    target = tmp_path / (letter * (length // len(letter.encode())))
    write_bytes(target, b"data")
    assert target.read_bytes() == b"data"
    assert names(tmp_path) == [target.name]


@pytest.mark.parametrize("umask", [0o022, 0o027, 0o077])
def test_new_file_gets_the_permissions_of_any_new_file(tmp_path, umask):
    before = os.umask(umask)
    try:
        write_bytes(tmp_path / "ours", b"data")
        (tmp_path / "any").write_bytes(b"data")
    finally:
        os.umask(before)
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "any").stat().st_mode


@pytest.mark.parametrize("mode", [0o600, 0o664, 0o606, 0o755])
def test_replaced_file_keeps_its_permissions(tmp_path, mode):
    target = tmp_path / "out"
    target.write_bytes(b"old")
    target.chmod(mode)
    write_bytes(target, b"new")
    assert target.read_bytes() == b"new"
    assert stat.S_IMODE(target.stat().st_mode) == mode


def test_what_replaces_a_private_file_is_private_from_the_start(tmp_path):
    target = tmp_path / "out"
    target.write_bytes(b"old")
    target.chmod(0o640)
    with replacing(target) as aside:
        assert stat.S_IMODE(aside.stat().st_mode) == 0o600


# --- links and devices ----------------------------------------------------------------------------------------------


def test_link_stays_and_its_target_is_replaced(tmp_path):
    (tmp_path / "there").mkdir()
    target, link = tmp_path / "there" / "out", tmp_path / "link"
    target.write_bytes(b"old")
    link.symlink_to("there/out")
    with replacing(link) as aside:
        assert aside.parent == target.parent
        aside.write_bytes(b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"


def test_dangling_link_gets_its_target(tmp_path):
    link = tmp_path / "link"
    link.symlink_to("later")
    write_bytes(link, b"data")
    assert link.is_symlink()
    assert (tmp_path / "later").read_bytes() == b"data"


def test_device_stays_a_device():
    write_bytes("/dev/null", b"data")
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


def test_full_device_says_what_to_do():
    with pytest.raises(ExchangeError, match=r"^/dev/full cannot be written: no space is left .* write elsewhere"):
        write_bytes("/dev/full", b"data")


def test_named_pipe_is_written_straight(tmp_path):
    pipe, got = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write_bytes(pipe, b"data")
    reader.join(10)
    assert got == [b"data"]
    assert names(tmp_path) == ["pipe"]


@pytest.mark.parametrize("to_file", [False, True])
def test_stdout_is_written_straight(tmp_path, to_file):
    code = "from cablecad.files import write_bytes; write_bytes('/dev/stdout', b'data')"
    if to_file:
        with (tmp_path / "out").open("wb") as out:
            subprocess.run([sys.executable, "-c", code], stdout=out, check=True)
        assert (tmp_path / "out").read_bytes() == b"data"
        assert names(tmp_path) == ["out"]
    else:
        assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout == b"data"


# --- what cannot be written -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "target", "said"),
    [
        (("sub", "mkdir"), "sub", "it is a folder; give the name of a file"),
        (None, "sub/", "it names a folder; give the name of a file"),
        (None, "sub/out", "its folder does not exist; create it"),
        (("file", "touch"), "file/out", "a part of its path is a file, not a folder"),
        (None, "n" * 256, "its name is too long; choose a shorter one"),
        (("round", "symlink_to", "round"), "round", "its symbolic links go round in a circle"),
        (None, "a\0b", "a path must not hold a null character"),
    ],
)
def test_refused_target_is_named_with_a_remedy(tmp_path, make, target, said):
    if make:
        name, method, *arguments = make
        getattr(tmp_path / name, method)(*arguments)
    before = names(tmp_path)
    with pytest.raises(ExchangeError) as caught:
        write_bytes(f"{tmp_path}/{target}", b"data")
    assert said in str(caught.value)
    assert (target[:9] if "\0" not in target else "a\\x00b") in str(caught.value)
    assert names(tmp_path) == before


def test_empty_path():
    with pytest.raises(ExchangeError, match="give the name of a file"):
        write_bytes("", b"data")


@pytest.fixture
def as_ordinary_user():
    """A folder of a user without privileges, as whom the test runs; root may write anywhere."""
    with tempfile.TemporaryDirectory() as name:
        folder, root = Path(name), os.geteuid() == 0
        if root:
            os.chown(folder, 65534, 65534)
            os.seteuid(65534)
        try:
            yield folder
        finally:
            if root:
                os.seteuid(0)
            folder.chmod(0o700)


def test_folder_that_may_not_be_written(as_ordinary_user):
    as_ordinary_user.chmod(0o500)
    with pytest.raises(ExchangeError, match=r"out cannot be written: that is not permitted; check the permissions"):
        write_bytes(as_ordinary_user / "out", b"data")


def test_file_that_may_not_be_written_is_not_replaced(as_ordinary_user):
    target = as_ordinary_user / "out"
    target.write_bytes(b"old")
    target.chmod(0o400)
    with pytest.raises(ExchangeError, match=r"out cannot be written: that is not permitted"):
        write_bytes(target, b"new")
    assert target.read_bytes() == b"old"
    assert names(as_ordinary_user) == ["out"]


def test_no_room_leaves_the_old_file(tmp_path):
    target = tmp_path / "out"
    target.write_bytes(b"old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(ExchangeError, match="it would be larger than the file system or a limit allows"):
            write_bytes(target, bytes(100_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert target.read_bytes() == b"old"
    assert names(tmp_path) == ["out"]


# --- blocks that fail -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("failure", [ValueError("mine"), KeyboardInterrupt(), SystemExit(3), ExchangeError("mine")])
def test_failing_block_leaves_nothing_and_its_exception_passes(tmp_path, failure):
    target = tmp_path / "out"
    target.write_bytes(b"old")

    def write_half():
        with replacing(target) as aside:
            aside.write_bytes(b"half")
            raise failure

    with pytest.raises(type(failure)) as caught:
        write_half()
    assert caught.value is failure
    assert target.read_bytes() == b"old"
    assert names(tmp_path) == ["out"]


def test_errors_about_other_files_pass_unchanged(tmp_path):
    with pytest.raises(FileNotFoundError, match="elsewhere"), replacing(tmp_path / "out"):
        (tmp_path / "elsewhere").read_bytes()
    assert names(tmp_path) == []


# --- other processes ------------------------------------------------------------------------------------------------


def test_what_a_killed_process_left_is_removed(tmp_path):
    target = tmp_path / "out"
    with python(HOLD, target, stdin=subprocess.PIPE) as process:
        process.stdout.readline()
        process.kill()
    assert len(names(tmp_path)) == 1
    write_bytes(target, b"data")
    assert names(tmp_path) == ["out"]


def test_what_several_killed_processes_left_is_removed(tmp_path):
    target = tmp_path / "out"
    processes = [python(HOLD, target, stdin=subprocess.PIPE) for _ in range(3)]
    for process in processes:
        process.stdout.readline()
    assert len(names(tmp_path)) == 3
    for process in processes:
        process.kill()
        process.communicate()
    write_bytes(target, b"data")
    assert names(tmp_path) == ["out"]


def test_what_a_live_process_is_writing_is_left_alone(tmp_path):
    target = tmp_path / "out"
    with python(HOLD, target, stdin=subprocess.PIPE) as process:
        aside = Path(process.stdout.readline().decode().strip())
        write_bytes(target, b"ours")
        assert aside.read_bytes() == b"other"
        assert target.read_bytes() == b"ours"
        process.communicate(b"\n")
    assert process.returncode == 0
    assert target.read_bytes() == b"other"
    assert names(tmp_path) == ["out"]


def test_nested_blocks_for_one_target(tmp_path):
    target = tmp_path / "out"
    with replacing(target) as one:
        one.write_bytes(b"one")
        with replacing(target) as two:
            two.write_bytes(b"two")
        assert target.read_bytes() == b"two"
    assert target.read_bytes() == b"one"
    assert names(tmp_path) == ["out"]


def test_two_processes_never_show_half_a_file(tmp_path):
    target, size = tmp_path / "out", 300_000
    processes = [python(WRITE_FOR_EVER, target, letter, size) for letter in ("A", "B")]
    try:
        for process in processes:
            process.stdout.readline()
        while not target.exists():
            time.sleep(0.01)
        seen, reads, give_up = set(), 0, time.monotonic() + 60
        while (len(seen) < 2 or reads < 200) and time.monotonic() < give_up:
            data = target.read_bytes()
            reads += 1
            assert len(data) == size
            assert data == data[:1] * size
            seen.add(data[:1])
        assert seen == {b"A", b"B"}
        assert [process.poll() for process in processes] == [None, None]
    finally:
        for process in processes:
            process.kill()
            process.communicate()


def test_kill_at_any_moment_leaves_the_old_or_the_new_file(tmp_path):
    target, size, chance = tmp_path / "out", 2_000_000, random.Random(7)
    target.write_bytes(b"A" * size)
    for _ in range(20):
        with python(WRITE_FOR_EVER, target, "AB", size) as process:
            process.stdout.readline()
            time.sleep(chance.uniform(0.0, 0.05))
            process.send_signal(signal.SIGKILL)
        data = target.read_bytes()
        assert len(data) == size
        assert data in (b"A" * size, b"B" * size)
        assert len(names(tmp_path)) <= 2  # what one left, the next has removed
    write_bytes(target, b"end")
    assert names(tmp_path) == ["out"]


# --- same_file ------------------------------------------------------------------------------------------------------


def test_same_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    one = tmp_path / "one"
    one.touch()
    (tmp_path / "two").touch()
    (tmp_path / "sub").mkdir()
    (tmp_path / "link").symlink_to("one")
    (tmp_path / "hard").hardlink_to(one)
    (tmp_path / "later link").symlink_to("later")
    for other in ("one", "sub/../one", "link", "hard"):
        assert same_file(one, other)
    assert not same_file(one, "two")
    assert not same_file(one, "later")
    assert same_file("later", tmp_path / "sub" / ".." / "later")
    assert same_file("later", "later link")
    assert not same_file("later", "sooner")
