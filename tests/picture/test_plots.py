"""Plots: what is drawn where, asked of matplotlib's own objects, and files that other programs read."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from cablecad import Cable, Clamp, Material, Pin, Port, Toward, load_scene, solve, solve_many
from cablecad.picture.curvature_plot import curvature_samples, plot_curvature
from cablecad.picture.equilibria_plot import equilibria_size, kind_of, plot_equilibria
from cablecad.picture.family_plot import Member, family_size, label_of, plot_family
from cablecad.picture.figure import UNSTABLE, fitted_size, sheet
from cablecad.picture.flat_view import flat_view
from cablecad.picture.palette import ALERT, on_paper
from cablecad.picture.plot import cable_plots, file_stem
from cablecad.picture.shape_plot import plot_shape, shape_size
from cablecad.pipeline import solve as solve_cable

UP = (0, 0, 1)
PVC = Material(youngs_modulus=3890.0, poissons_ratio=0.25)
SAMPLES = Path(__file__).parents[2] / "samples"
BLUE = "#0072b2"


def arch(**keys) -> Cable:
    """In the plane x = 0."""
    values = {"name": "W1", "diameter": 4.0, "length": 350.0, "material": PVC, **keys}
    return Cable(start=Port((0, 0, 0), UP), end=Port((0, 120, 0), UP), **values)


def lines_of(axes, color=None):
    """Points of the lines of an axes, of a colour if one is given."""
    from matplotlib.colors import to_hex

    return [np.array(line.get_xydata()) for line in axes.lines if color in (None, to_hex(line.get_color()))]


def words_of(axes) -> str:
    return "\n".join(text.get_text() for text in axes.texts)


# --- the view --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "end", "labels"),
    [
        ((0, 0, 0), (0, 120, 0), ("Y [mm]", "Z [mm]")),
        ((0, 0, 0), (-120, 0, 0), ("X [mm]", "Z [mm]")),
        ((0, 50, 7), (120, 50, 9), ("X [mm]", "Z [mm]")),
    ],
)
def test_upright_planes_are_drawn_in_the_scenes_own_coordinates(start, end, labels):
    solution = solve(Cable("W1", 4.0, Port(start, UP), Port(end, UP), length=350.0))
    view = flat_view(solution.centreline)
    assert view.labels == labels
    axes = ["XYZ".index(label[0]) for label in labels]
    points = solution.points(20)
    np.testing.assert_allclose(view.flat(points), points[:, axes], atol=1e-9)


def test_level_plane_has_y_upwards():
    view = flat_view(
        solve(Cable("W1", 4.0, Port((0, 0, 5), (0, 1, 0)), Port((120, 0, 5), (0, 1, 0)), length=350.0)).centreline
    )
    assert view.labels == ("X [mm]", "Y [mm]")


def test_oblique_plane_keeps_lengths_and_has_z_upwards():
    solution = solve(Cable("W1", 4.0, Pin((10, 0, 0)), Pin((110, 80, 60)), length=250.0))
    view, points = flat_view(solution.centreline), solution.points(50)
    flat = view.flat(points)
    np.testing.assert_allclose(
        np.linalg.norm(flat[:, None] - flat, axis=2), np.linalg.norm(points[:, None] - points, axis=2), atol=1e-9
    )
    assert view.up[2] > 0.5
    assert "[mm]" in view.labels[0]
    np.testing.assert_allclose(flat[0], 0.0, atol=1e-9)


def test_straight_cable_is_drawn_upright():
    view = flat_view(solve(Cable("W1", 4.0, Pin((0, 0, 0)), Pin((0, 0, 100)), length=100.0)).centreline)
    assert view.labels == ("Y [mm]", "Z [mm]")


# --- shape -----------------------------------------------------------------------------------------------------------


def test_shape_shows_curve_ends_forces_and_the_tightest_spot():
    solution = solve(arch())
    with sheet(8.0, 6.0) as figure:
        plot_shape(figure, solution, BLUE)
        (axes,) = figure.axes
        (curve,) = lines_of(axes, BLUE)
        np.testing.assert_allclose(curve, solution.points(len(curve))[:, [1, 2]], atol=1e-9)
        marks = [line for line in axes.lines if line.get_marker() == "o"]
        (mark,) = [line for line in marks if line.get_markeredgecolor() == ALERT]
        spot = solution.position(solution.bend_radius_min_at)[0]
        np.testing.assert_allclose(np.ravel(mark.get_xydata()), spot[[1, 2]], atol=1e-9)
        # The circle that touches there has the bend radius; its middle is below the arch's top.
        circle = next(points for points in lines_of(axes, ALERT) if len(points) > 100)
        middle = spot[[1, 2]] - [0.0, solution.bend_radius_min]
        np.testing.assert_allclose(np.linalg.norm(circle - middle, axis=1), solution.bend_radius_min, rtol=1e-9)
        words = words_of(axes)
        force = solution.EI * np.linalg.norm(solution.equilibrium.start.force_per_EI)
        assert f"start\n{force:.4g} N\n" in words
        assert f"R {solution.bend_radius_min:.4g} mm\ns = 175 mm" in words
        # An arrow at each end points the way the support pushes.
        arrows = [text for text in axes.texts if getattr(text, "arrow_patch", None) is not None]
        assert len(arrows) == 2
        for arrow, state in zip(arrows, (solution.equilibrium.start, solution.equilibrium.end), strict=True):
            way = np.array(arrow.xy) - np.array(arrow.get_position())
            way, push = way / np.linalg.norm(way), state.force_per_EI[[1, 2]]
            np.testing.assert_allclose(arrow.xy, state.position[[1, 2]], atol=1e-9)
            assert way @ push / np.linalg.norm(push) == pytest.approx(1.0)


def test_moments_turn_the_way_the_support_turns_the_cable():
    """About an axis out of the drawing, which is +x here: counterclockwise is positive."""
    solution = solve(arch())
    with sheet(8.0, 6.0) as figure:
        plot_shape(figure, solution, BLUE)
        texts = {text.get_text().split("\n")[0]: text.get_text() for text in figure.axes[0].texts}
    for name, state in (("start", solution.equilibrium.start), ("end", solution.equilibrium.end)):
        moment = solution.EI * state.moment_per_EI[0]
        assert texts[name].endswith(f"{'↺' if moment > 0.0 else '↻'} {abs(moment):.4g} N mm")


def test_without_a_material_forces_are_per_stiffness():
    with sheet(8.0, 6.0) as figure:
        plot_shape(figure, solve(arch(material=None)), BLUE)
        assert "EI /mm²" in words_of(figure.axes[0])


def test_pins_have_no_moment_and_a_straight_cable_no_force():
    with sheet(8.0, 6.0) as figure:
        plot_shape(figure, solve(Cable("W1", 4.0, Pin((0, 0, 0)), Pin((0, 120, 0)), length=130.0, material=PVC)), BLUE)
        assert "N mm" not in words_of(figure.axes[0])
    with sheet(8.0, 6.0) as figure:
        plot_shape(figure, solve(Cable("W1", 4.0, Pin((0, 0, 0)), Pin((0, 120, 0)), length=120.0, material=PVC)), BLUE)
        words = words_of(figure.axes[0])
        assert " N" not in words
        assert "R " not in words


@pytest.mark.parametrize("name", ["W1", "W2", "W3"])
def test_words_hide_neither_each_other_nor_the_cable(name):
    (cable,) = (cable for cable in load_scene(SAMPLES / "loom.toml").cables if cable.name == name)
    solution = solve(cable)
    plot = next(cable_plots([solution]))
    with sheet(*plot.size) as figure:
        plot.draw(figure)
        figure.draw_without_rendering()
        (axes,) = figure.axes
        boxes = [
            text.get_window_extent()
            for text in axes.texts
            if getattr(text, "arrow_patch", None) is None and "\n" in text.get_text()
        ]
        assert len(boxes) == 3
        for i, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[:i])
            curve = axes.transData.transform(max(lines_of(axes, cable.color), key=len))
            assert not any(box.contains(x, y) for x, y in curve)
            assert all(figure.bbox.contains(*corner) for corner in box.corners())


# --- curvature -------------------------------------------------------------------------------------------------------


def test_curvature_over_arclength_with_its_rule():
    solution = solve(arch(min_bend_radius=60.0))
    with sheet(8.0, 4.5) as figure:
        plot_curvature(figure, solution, BLUE)
        axes, beside = figure.axes
        (curve,) = lines_of(axes, BLUE)
        assert (curve[0, 0], curve[-1, 0]) == (0.0, 350.0)
        np.testing.assert_allclose(np.abs(curve[:, 1]), np.abs(solution.curvature(curve[:, 0])), atol=1e-15)
        assert curve[len(curve) // 2, 1] > 0.0  # the tightest bend is positive
        (mark,) = [line for line in axes.lines if line.get_marker() == "o"]
        np.testing.assert_allclose(np.ravel(mark.get_xydata()), [175.0, 1.0 / solution.bend_radius_min], rtol=1e-6)
        rules = [line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"]
        assert 1.0 / 60.0 in rules
        assert "rule: at least 60 mm" in words_of(axes)
        assert "is broken" in words_of(axes)
        # At the right the same height has the radius.
        assert beside.get_ylim() == axes.get_ylim()
        for label in beside.get_yticklabels():
            if label.get_text() != "straight":
                assert float(label.get_text()) == pytest.approx(1.0 / abs(label.get_position()[1]), rel=1e-9)


def test_rule_far_above_the_curve_is_left_out():
    with sheet(8.0, 4.5) as figure:
        plot_curvature(figure, solve(arch(min_bend_radius=5.0)), BLUE)
        assert "rule: at least" not in words_of(figure.axes[0])
        assert "its rule of at least 5 mm is kept" in words_of(figure.axes[0])


def test_curvature_jumps_at_a_break():
    cable = Cable("W1", 4.0, Port((0, 0, 0), UP, straight=30.0), Port((0, 120, 0), UP), length=350.0)
    solution = solve(cable)
    s, kappa = curvature_samples(solution)
    before, after = kappa[s == 30.0]
    assert before == 0.0
    assert after == solution.curvature(30.0, side="right")[0] != 0.0


# --- equilibria ------------------------------------------------------------------------------------------------------


def test_equilibria_are_told_apart_by_line_and_word():
    solution = solve_cable(load_scene(SAMPLES / "loom.toml").cables[2], search="wide")
    kinds = [kind_of(equilibrium) for equilibrium in solution.equilibria]
    assert set(kinds) == {"stable", "leaves", "unstable"}
    with sheet(*equilibria_size(solution)) as figure:
        plot_equilibria(figure, solution)
        fields = figure.axes[: len(kinds)]
        for i, (axes, kind) in enumerate(zip(fields, kinds, strict=True)):
            equilibrium = solution.equilibria[i]
            curve = axes.lines[0]
            assert (curve.get_linestyle() == "--") == (kind == "unstable")
            assert (curve.get_color() == UNSTABLE) == (kind == "unstable")
            words = words_of(axes)
            assert ("stable only in its plane" in words, words.endswith("unstable")) == (
                kind == "leaves",
                kind == "unstable",
            )
            assert f"{float(f'{solution.EI * equilibrium.energy_per_EI:.4g}'):.10g} N mm" in words
            drawn = np.array(curve.get_xydata())
            length = np.linalg.norm(np.diff(drawn, axis=0), axis=1).sum()
            assert length == pytest.approx(210.0, rel=1e-3)
        spans = {round(float(np.ptp(axes.get_xlim())), 6) for axes in fields}
        assert len(spans) == 1  # one scale
        titles = [axes.get_title(loc="left") for axes in fields]
        assert titles == ["0 – the answer", *map(str, range(1, len(kinds)))]


# --- family ----------------------------------------------------------------------------------------------------------


def figure_6():
    """The paper's: 350 mm, pinned, by end angle."""
    angles = (20.0, 90.0, 150.0)
    cables = [Cable("W1", 4.0, Pin((0, 0, 0)), Toward((1, 0, 0)), length=350.0, angle_deg=angle) for angle in angles]
    return [Member(angle, solution) for angle, solution in zip(angles, solve_many(cables), strict=True)]


def test_family_is_one_drawing_dark_to_light_and_dashed_where_unstable():
    members = figure_6()
    with sheet(8.5, 6.0) as figure:
        plot_family(figure, "W1", "cables.W1.angle_deg", members, 2)
        axes = figure.axes[0]
        curves = [line for line in axes.lines if line.get_marker() == "None"]
        assert [line.get_linestyle() for line in curves] == ["-", "-", "--"]
        for line, member in zip(curves, members, strict=True):
            np.testing.assert_allclose(line.get_xydata(), member.solution.points(401)[:, [0, 2]], atol=1e-9)
        brightness = [np.dot(line.get_color()[:3], [0.2126, 0.7152, 0.0722]) for line in curves]
        assert brightness == sorted(brightness)
        assert "angle [degrees]: 3 shapes from 20 to 150; 2 more have no solution" in words_of(axes)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("cables.W1.length", "length [mm]"),
        ("cables.W1.angle_deg", "angle [degrees]"),
        ("cables.W1.end.position[1]", "end position Y [mm]"),
        ("cables.W1.min_bend_radius", "min bend radius [mm]"),
        ("cables.W1.slack", "slack"),
    ],
)
def test_what_changes_is_named_with_its_unit(place, words):
    assert label_of(place) == words


def test_family_across_planes_is_drawn_from_each_ones_start():
    ends = [(0.0, 120.0, 0.0), (120.0, 0.0, 0.0)]
    cables = [
        Cable("W1", 4.0, Clamp((5, 5, 5), UP), Clamp(tuple(np.add(end, 5.0)), (0, 0, -1)), length=350.0) for end in ends
    ]
    members = [Member(float(i), solution) for i, solution in enumerate(solve_many(cables))]
    with sheet(8.5, 6.0) as figure:
        plot_family(figure, "W1", "cables.W1.end.position[0]", members, 0)
        axes = figure.axes[0]
        assert "own plane" in axes.get_xlabel()
        first, second = (np.array(line.get_xydata()) for line in axes.lines if line.get_marker() == "None")
    np.testing.assert_allclose(first, second, atol=1e-6)


# --- files -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("file_format", "start"), [("png", b"\x89PNG\r\n"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_files_are_the_same_twice(file_format, start):
    plot = next(cable_plots([solve(arch())]))
    data = [plot.data(file_format) for _ in range(2)]
    assert data[0].startswith(start)
    assert data[0] == data[1]


def test_names_that_are_no_formulas_and_no_letters_of_the_type():
    cable = Cable("$x_1^ 电缆 \\frac", 4.0, Port((0, 0, 0), UP), Port((0, 120, 0), UP), length=350.0)
    for plot in cable_plots([solve(cable)]):
        assert plot.data("png").startswith(b"\x89PNG")


def test_a_users_own_style_changes_nothing():
    import matplotlib as mpl

    plot = next(cable_plots([solve(arch())]))
    usual = plot.data("png")
    with mpl.rc_context({"font.size": 30.0, "axes.facecolor": "black", "savefig.dpi": 30}):
        assert plot.data("png") == usual
        assert mpl.rcParams["font.size"] == 30.0


def test_nothing_is_cut_off_at_the_border():
    from matplotlib.image import imread

    for plot in cable_plots([solve(load_scene(SAMPLES / "loom.toml").cables[2])]):
        pixels = imread(io.BytesIO(plot.data("png")))[:, :, :3]
        border = np.concatenate(
            [
                pixels[:4].reshape(-1, 3),
                pixels[-4:].reshape(-1, 3),
                pixels[:, :4].reshape(-1, 3),
                pixels[:, -4:].reshape(-1, 3),
            ]
        )
        assert border.min() == 1.0, plot.name


def test_stems_are_file_names_and_differ():
    taken: set[str] = set()
    stems = [file_stem(name, taken) for name in ("W1", "w1", "a/b", "a b", "..", "x" * 300, "电缆", "\\:*?")]
    assert stems[:4] == ["W1", "w1_2", "a_b", "a_b_2"]
    assert stems[4] == "cable"
    assert len(stems[5]) == 80
    assert stems[6:] == ["电缆", "cable_2"]


def test_sheets_fit_what_is_on_them():
    wide, high = fitted_size((300.0, 40.0)), fitted_size((40.0, 300.0))
    assert wide[0] > 2.0 * wide[1]
    assert high[1] > high[0]
    assert all(
        math.isfinite(side) and 3.0 < side < 10.0 for size in (wide, high, fitted_size((0.0, 0.0))) for side in size
    )


def test_lines_on_white_paper_are_never_white():
    assert on_paper("#0072b2") == "#0072b2"
    assert on_paper("#000000ff") == "#000000"
    assert on_paper("#ffffff") == "#9e9e9e"
    red, green, blue = bytes.fromhex(on_paper("#ffff00")[1:])
    assert red == green > 10 * blue
    assert red < 180


def test_a_thick_cable_lies_within_its_sheet_and_between_its_walls():
    solution = solve(arch(diameter=60.0, allow_contact=True))
    with sheet(*shape_size(solution)) as figure:
        plot_shape(figure, solution, "#0072b2")
        axes = figure.axes[0]
        low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
        side = axes.patches[0].get_xy()
        assert (side.min(axis=0) > low).all()
        assert (side.max(axis=0) < high).all()


def test_titles_say_what_is_wrong_and_end_where_the_sheet_does():
    cable = load_scene(SAMPLES / "crossed.toml").cables[0]
    solution = solve(cable)
    with sheet(*shape_size(solution)) as figure:
        plot_shape(figure, solution, "#0072b2")
        assert figure.axes[0].get_title(loc="left").endswith(": unstable, cuts into itself")
    solution = solve(arch(name="Harness main trunk A, connector X12-J7 to PCB backplane (rev C) left" * 3))
    with sheet(*shape_size(solution)) as figure:
        plot_shape(figure, solution, "#0072b2")
        title = figure.axes[0].get_title(loc="left")
        assert title.endswith("...")
        assert len(title) < 70


def test_a_family_of_straight_cables_has_room_across():
    ends = Clamp((0, 0, 0), (1, 0, 0)), Clamp((100, 0, 0), (1, 0, 0))
    members = [Member(d, solve(Cable("S", d, *ends, length=100.0))) for d in (1.0, 2.0)]
    with sheet(*family_size(members)) as figure:
        plot_family(figure, "S", "cables.S.diameter", members, 1)
        low, high = figure.axes[0].get_ylim()
        assert high - low > 15.0
        assert "2 shapes from 1 to 2; 1 more has no solution" in words_of(figure.axes[0])
