"""Tables of overrides: cells to values, rows to scenes, and every mistake with its line before anything runs."""

from __future__ import annotations

import pytest
from variants import CLAMPED, write

from cablecad.batch import table_rows
from cablecad.errors import ExchangeError, SceneError


@pytest.fixture
def scene(tmp_path):
    return write(tmp_path / "scene.toml", CLAMPED)


def rows_of(tmp_path, scene, text, name="table.csv"):
    return list(table_rows(write(tmp_path / name, text), scene))


def mistakes_of(tmp_path, scene, text, name="table.csv"):
    with pytest.raises(SceneError) as caught:
        rows_of(tmp_path, scene, text, name)
    return [str(mistake) for mistake in caught.value.mistakes]


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_csv(tmp_path, scene, delimiter):
    text = (
        "\ufeffid,cables.W1.length,cables.W1.end.position[1],cables.W1.color\r\na,300,1.1e2,#2b6cb0\r\n\r\n b ,,90,\r\n"
    )
    a, b = rows_of(tmp_path, scene, text.replace(",", delimiter))
    assert (a.id, b.id) == ("a", "b")
    assert a.overrides == {"cables.W1.length": 300, "cables.W1.end.position[1]": 110.0, "cables.W1.color": "#2b6cb0"}
    assert b.overrides == {"cables.W1.end.position[1]": 90}
    first, second = a.resolve().cables[0], b.resolve().cables[0]
    assert (first.length, first.end.position, first.color) == (300, (0, 110, 0), "#2b6cb0")
    assert (second.length, second.end.position, second.color) == (350, (0, 90, 0), None)


def test_jsonl(tmp_path, scene):
    text = (
        '{"id": 7, "cables.W1.end.position": [0, 90, 0], "cables.W1.allow_contact": true}\n\n'
        '{"cables.W1.length": null, "cables.W1.slack": 2.0}\n'
    )
    a, b = rows_of(tmp_path, scene, text, "table.jsonl")
    assert (a.id, b.id) == ("7", "2")
    assert a.resolve().cables[0].end.position == (0, 90, 0)
    assert a.resolve().cables[0].allow_contact is True
    assert (b.resolve().cables[0].length, b.resolve().cables[0].slack) == (None, 2.0)


def test_rows_of_json_lines_may_name_what_others_name_a_part_of(tmp_path, scene):
    whole, part = '"cables.W1.start.outward": [0, 1, 0]', '"cables.W1.start.outward[1]": 2'
    a, b = rows_of(tmp_path, scene, f"{{{whole}}}\n{{{part}}}\n", "table.jsonl")
    assert [row.resolve().cables[0].start.outward for row in (a, b)] == [(0, 1, 0), (0, 2, 1)]
    found = mistakes_of(tmp_path, scene, f"{{{part}}}\n{{{whole}, {part}}}\n{{{whole}, {part}}}\n", "table.jsonl")
    assert found == [
        "line 2, cables.W1.start.outward[1]: names what cables.W1.start.outward names too, or a part of it; keep one"
    ]


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("before", ["", "\n", " \r\n\n", ";;\n"])
def test_the_header_tells_what_parts_the_columns(tmp_path, scene, delimiter, before):
    """Neither a blank line before it nor what stands in its quotes."""
    write(scene, CLAMPED.replace('"W1"', '"a, b; c, d, e, f"'))
    row = 'id|"cables.""a, b; c, d, e, f"".length"|name\nx|300|y\n'.replace("|", delimiter)
    (one,) = rows_of(tmp_path, scene, before.replace(";", delimiter) + row)
    assert (one.id, one.resolve().cables[0].length) == ("x", 300)


def test_whole_numbers_as_spreadsheets_write_them(tmp_path, scene):
    """A column with gaps comes out of many programs as 1.0, where only a whole number may stand."""
    text = "id,cables.W1.equilibrium,cables.W1.length\na,0,300.0\nb,1.0,310\nc,,\n"
    a, b, c = rows_of(tmp_path, scene, text)
    assert [row.resolve().cables[0].equilibrium for row in (a, b, c)] == [0, 1, 0]
    assert type(a.overrides["cables.W1.length"]) is float
    (said,) = mistakes_of(tmp_path, scene, "cables.W1.equilibrium\n1.5\n")
    assert "must be an index" in said


def test_cells_hold_what_their_column_takes(tmp_path, scene):
    text = (
        "name,cables.W1.length,cables.W1.min_bend_radius,cables.W1.bulge,cables.W1.equilibrium,cables.W1.allow_contact\n"
        'true,shortest,40,"[1, 0, 0]","{""winding"": 1}",TRUE\n'
        "007,350,.5,,2,false\n"
    )
    one, two = (row.resolve() for row in rows_of(tmp_path, scene, text))
    cable = one.cables[0]
    assert (one.name, cable.length, cable.bulge, cable.equilibrium.winding) == ("true", "shortest", (1, 0, 0), 1)
    assert cable.allow_contact is True
    assert (two.name, two.cables[0].equilibrium, two.cables[0].min_bend_radius) == ("007", 2, 0.5)


def test_all_mistakes_of_header_and_types_at_once(tmp_path, scene):
    text = (
        "id,cables.W1.lenght,cables.W2.length,cables.W1.length,cables.W1.end.position[1]\n"
        "a,1,2,300 mm,100\nb,1,2,300,1O0\n../c,1,2,nan,100\nd,1,2\n"
    )
    found = mistakes_of(tmp_path, scene, text)
    assert [one.partition(":")[0] for one in found] == [
        "line 2, cables.W1.lenght",
        "line 2, cables.W2.length",
        "line 2, cables.W1.length = '300 mm'",
        "line 3, cables.W1.end.position[1] = '1O0'",
        "line 4, id = '../c'",
        "line 4, cables.W1.length = 'nan'",
        "line 5",
    ]
    assert "did you mean 'length'?" in found[0]
    assert "no cable 'W2'; the scene has W1" in found[1]
    assert "must be a number" in found[3]
    assert "has 3 cells, and the header 5" in found[6]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("id,id\na,b\n", "names 2 columns; keep one"),
        ("id,,cables.W1.length\na,1,2\n", "column 2: has no name"),
        ("cables.W1.length,cables[0].length\n1,2\n", "names what cables.W1.length names too"),
        ('cables.W1.end,cables.W1.end.position[0]\n"{}",2\n', "names what cables.W1.end names too"),
        ("id,cables.W1.length\n", "holds no rows"),
        ("", "holds no rows"),
        ('id,cables.W1.length\n"a,1\n', "is no CSV"),
    ],
)
def test_csv_that_is_none(tmp_path, scene, text, words):
    assert any(words in one for one in mistakes_of(tmp_path, scene, text))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"id": "a"\n', "line 1: is not valid JSON"),
        ("[1]\n", "line 1: must be a table of dotted names"),
        ('{"id": "a", "id": "b"}\n', "line 1: has 'id' more than once"),
        ('{"cables.W1.length": "350"}\n', "line 1, cables.W1.length = '350': must be a finite number of mm"),
        ('{"cables.W1.length": 1e999}\n', "line 1, cables.W1.length = inf: must be a finite number"),
        ('{"cables.W1.length": true}\n', "line 1, cables.W1.length = True: must be a"),
        ('{"id": ["a"]}\n', "line 1, id = ['a']: must be a text"),
        ('{"id": "\\ud800"}\n', "line 1, id"),
        ('{"cables.W1.color": "\\ud800"}\n', "half a character"),
        ('{"cables.W1.end.position[1]": null}\n', "line 1, cables.W1.end.position[1] = None: must be a number"),
        ("[" * 100_000 + "\n", "is nested too deep"),
        (f'{{"cables.W1.length": {"9" * 5000}}}\n', "must be a finite number"),
    ],
)
def test_jsonl_that_is_none(tmp_path, scene, text, words):
    assert any(words in one for one in mistakes_of(tmp_path, scene, text, "table.jsonl"))


def test_a_thousand_mistakes_are_not_told_one_by_one(tmp_path, scene):
    found = mistakes_of(tmp_path, scene, "cables.W1.length\n" + "x\n" * 1000)
    assert len(found) == 101
    assert "no line after 101 was looked at" in found[-1]


def test_values_out_of_range_are_the_rows_own(tmp_path, scene):
    bad, good = rows_of(tmp_path, scene, "cables.W1.length\n-5\n300\n")
    with pytest.raises(SceneError, match=r"cables\.W1\.length = -5.0: must be greater than 0"):
        bad.resolve()
    assert good.resolve().cables[0].length == 300


@pytest.mark.parametrize(
    ("row_id", "fine"),
    [("a b", True), ("Ä-1", True), ("a/b", False), ("a:b", False), (".a", False), ("x" * 201, False), ("a\x07", False)],
)
def test_an_id_must_name_a_file(tmp_path, scene, row_id, fine):
    text = f'id,cables.W1.length\n"{row_id}",300\n'
    if fine:
        assert rows_of(tmp_path, scene, text)[0].id == row_id
    else:
        assert "it names a file" in mistakes_of(tmp_path, scene, text)[0]


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("table.xlsx", b"PK", "its name must end in .csv or .jsonl"),
        ("table.csv", None, "cannot be read: No such file"),
        ("table.csv", b"id,cables.W1.length\n\xff,300\n", "is not UTF-8 text"),
    ],
)
def test_tables_that_cannot_be_read(tmp_path, scene, name, content, words):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ExchangeError, match=words):
        table_rows(path, scene)
