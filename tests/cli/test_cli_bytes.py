"""The same input gives the same bytes: in any process, any folder, at any time, for any user."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest

SAMPLES = Path(__file__).parents[2] / "samples"


def test_same_bytes_in_any_process_folder_time_and_for_any_user(process, tmp_path):
    """One run in the samples' folder, one in another by a relative path, one on a copy of them elsewhere."""
    copy = tmp_path / "elsewhere Ω" / "samples"
    shutil.copytree(SAMPLES, copy)
    there = tmp_path / "there"
    there.mkdir()
    runs = [
        ("0", SAMPLES, "connectors.toml", "ann"),
        ("1", there, os.path.relpath(SAMPLES / "connectors.toml", there), "bob"),
        ("4294967295", copy, copy / "connectors.toml", "carol"),
    ]
    results = []
    for i, (seed, folder, scene, user) in enumerate(runs):
        home = tmp_path / f"home-of-{user}"
        home.mkdir()
        environment = {key: value for key, value in os.environ.items() if key != "SOURCE_DATE_EPOCH"}
        environment |= {"PYTHONHASHSEED": seed, "USER": user, "LOGNAME": user, "HOME": str(home), "TZ": f"UTC{i * 5}"}
        one = process("build", scene, "-o", tmp_path / f"{user}.step", cwd=folder, env=environment)
        out, err = one.communicate()
        assert (one.returncode, out, err) == (0, f"{tmp_path / user}.step\n", "")
        results.append((tmp_path / f"{user}.step").read_bytes())
    assert results[0] == results[1] == results[2]
    (text,) = set(results)
    assert text.isascii()
    for secret in (
        "ann'",
        "bob",
        "carol",
        "home-of",
        "/",
        "\\\\",
        "elsewhere",
        "samples",
        os.uname().nodename,
        ".step",
    ):
        assert secret.encode() not in text
    assert b"'1970-01-01T00:00:00'" in text


@pytest.mark.parametrize(("epoch", "stamp"), [("1", "1970-01-01T00:00:01"), ("1700000000", "2023-11-14T22:13:20")])
def test_time_is_source_date_epoch(cli, tmp_path, monkeypatch, epoch, stamp):
    texts = []
    for value in ("0", epoch):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", value)
        assert cli("build", SAMPLES / "paper.toml", "-o", tmp_path / "out.step").code == 0
        texts.append((tmp_path / "out.step").read_text())
    assert f"'{stamp}'" in texts[1]
    assert re.sub(r"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'", "", texts[0]) == texts[1].replace(f"'{stamp}'", "")


@pytest.mark.parametrize("epoch", ["yesterday", "-1", "1e9"])
def test_source_date_epoch_that_is_no_time(cli, tmp_path, monkeypatch, epoch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    ended = cli("build", SAMPLES / "paper.toml", "-o", tmp_path / "out.step")
    assert (ended.code, ended.out) == (2, "")
    assert f"SOURCE_DATE_EPOCH is {epoch!r}" in ended.err
    assert "whole seconds since 1970" in ended.err
    assert list(tmp_path.iterdir()) == []


def test_name_of_the_output_does_not_matter(cli, tmp_path):
    for name in ("a.step", "another name.stp"):
        assert cli("build", SAMPLES / "paper.toml", "-o", tmp_path / name).code == 0
    one, other = (path.read_bytes() for path in tmp_path.iterdir())
    assert one == other
