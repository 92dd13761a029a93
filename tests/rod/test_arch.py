"""The arch from any two of its data, against mpmath."""

from __future__ import annotations

import itertools
import math

import mpmath as mp
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracle import PinnedOracle

from cablecad.errors import InfeasibleError, SceneError
from cablecad.model import Cable, Pin
from cablecad.rod import pinned_data
from cablecad.rod.arch import FIGURE_EIGHT, HIGHEST, WIDEST_BEND, Arch
from cablecad.rod.pinned_data import solve_pinned
from cablecad.rod.solve import solve_rod

PAIRS = [
    pair
    for pair in itertools.combinations(["length", "chord", "rise", "bend_radius", "force", "angle_deg", "slack"], 2)
    if set(pair) != {"angle_deg", "slack"}
]


def relative(value: float, exact: mp.mpf) -> float:
    return float(abs(mp.mpf(value) - exact) / abs(exact))


CASES = [
    (pair, angle)
    for pair in PAIRS
    for angle in (5.0, 20.0, 60.0, 90.0, 125.0, 135.0, 170.0)
    if "slack" not in pair or angle < 130.7  # a slack is of a positive chord
]


@pytest.mark.parametrize(("pair", "angle"), CASES)
def test_two_data_give_all_others(pair: tuple[str, str], angle: float) -> None:
    exact = PinnedOracle(350.0, angle_deg=angle).data
    solved = solve_pinned({key: float(exact[key]) for key in pair}, EI=1.0)
    answers = [solved] if solved.other is None else [solved, solved.other]
    best = min(answers, key=lambda answer: abs(math.degrees(answer.arch.angle) - angle))
    # Data with a maximum (rise, chord over bend radius) and a force near the Euler load amplify their own rounding.
    for key in ("length", "rise", "bend_radius", "force", "angle_deg"):
        assert relative(best.datum(key, EI=1.0), exact[key]) < 1e-12, key
    assert abs(best.chord - float(exact["chord"])) < 1e-12 * 350.0


@given(st.floats(-6.0, math.log10(179.9)), st.sampled_from(PAIRS), st.floats(-6, 6))
@settings(max_examples=150, deadline=None)
def test_given_data_are_met(log_angle: float, pair: tuple[str, str], log_length: float) -> None:
    """Whatever the conditioning, the two given data come back."""
    exact = PinnedOracle(10.0**log_length, angle_deg=10.0**log_angle).data
    data = {key: float(exact[key]) for key in pair}
    assume(data.get("slack", 1.0) > 0.0)
    # To rounding the Euler load itself, or the straight cable: both are refused, and tested below.
    assume(not ({"force", "slack"} & set(pair) or pair == ("length", "chord")) or log_angle > -5.0)
    assume(pair != ("length", "chord") or 1.0 - data["chord"] / data["length"] > 1e-15)
    solved = solve_pinned(data, EI=1.0)
    for key, value in data.items():
        assert solved.datum(key, EI=1.0) == pytest.approx(value, rel=2e-13, abs=1e-13 * solved.length), key


@pytest.mark.parametrize("exponent", range(-12, 0))
def test_slack_keeps_relative_precision(exponent: int) -> None:
    """The rise of a hair of slack is right to 1e-13 of itself, far below what positions could tell."""
    slack = 10.0**exponent
    solved = solve_pinned({"slack": slack, "chord": 100.0})
    ratio = mp.mpf(slack) / (1 + mp.mpf(slack))
    m = mp.findroot(lambda m: 2 * (mp.ellipk(m) - mp.ellipe(m)) / mp.ellipk(m) - ratio, ratio)
    exact = PinnedOracle(mp.mpf(100) * (1 + mp.mpf(slack)), m=m).data
    assert relative(solved.datum("rise"), exact["rise"]) < 1e-13
    assert relative(solved.datum("slack"), mp.mpf(slack)) < 1e-13


def test_turning_points_are_where_their_names_say() -> None:
    highest = mp.findroot(lambda m: mp.diff(lambda x: mp.sqrt(x) / mp.ellipk(x), m), 0.7)
    eight = mp.findroot(lambda m: 2 * mp.ellipe(m) - mp.ellipk(m), 0.82).real
    widest = mp.findroot(lambda m: mp.diff(lambda x: mp.sqrt(x) * (2 * mp.ellipe(x) - mp.ellipk(x)), m), 0.35)
    for arch, m in ((HIGHEST, highest), (FIGURE_EIGHT, eight), (WIDEST_BEND, widest)):
        assert relative(arch.m, m) < 4e-16
        assert relative(arch.m1, 1 - m) < 4e-16


def test_two_answers_smaller_angle_first() -> None:
    for data in ({"length": 350.0, "rise": 120.0}, {"chord": 100.0, "bend_radius": 60.0}):
        solved = solve_pinned(data)
        assert solved.other is not None
        assert solved.arch.angle < solved.other.arch.angle
        for key, value in data.items():
            assert solved.datum(key) == pytest.approx(value, rel=1e-13)
            assert solved.other.datum(key) == pytest.approx(value, rel=1e-13)


def test_third_datum_picks_between_two_answers() -> None:
    both = solve_pinned({"length": 350.0, "rise": 120.0})
    assert both.other is not None
    picked = solve_pinned({"length": 350.0, "rise": 120.0, "bend_radius": both.other.datum("bend_radius")})
    assert picked.arch.angle == pytest.approx(both.other.arch.angle, rel=1e-12)
    assert picked.other is None


def test_greatest_rise_is_met_at_its_maximum() -> None:
    at_most = HIGHEST.size("rise") / HIGHEST.size("length")
    solved = solve_pinned({"length": 1.0, "rise": at_most})
    assert solved.arch.angle == pytest.approx(HIGHEST.angle, abs=1e-6)
    with pytest.raises(InfeasibleError, match=r"at most 0\.4031402 of its length"):
        solve_pinned({"length": 1.0, "rise": at_most * 1.001})


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"length": 350.0, "force": 3.9}, r"does not exceed the Euler load 3\.938"),
        ({"length": 350.0, "force": 4.75e-3}, "stays straight"),
        ({"chord": 350.0, "force": 4.0}, r"less than 3\.938"),
        ({"length": 100.0, "chord": 120.0}, r"lacks 20 mm"),
        ({"length": 100.0, "chord": -100.0}, "not more than"),
        ({"length": 100.0, "chord": -99.9}, "-0.994"),
        ({"chord": 100.0, "bend_radius": 10.0}, "at most 2.605568 of its bend_radius"),
        ({"rise": 100.0, "bend_radius": 10.0}, "less than 4 of its bend_radius"),
        ({"rise": 300.0, "force": 4.0}, "less than 2 of its sqrt"),
        ({"bend_radius": 10.0, "force": 4.0}, "more than 0.5 of its sqrt"),
        ({"chord": 100.0, "angle_deg": 140.0}, "ends have crossed"),
        ({"chord": -100.0, "angle_deg": 90.0}, "ends have crossed"),
        ({"chord": 0.0, "angle_deg": 90.0}, "ends have crossed"),
    ],
)
def test_out_of_reach(data: dict[str, float], words: str) -> None:
    with pytest.raises(InfeasibleError, match=words):
        solve_pinned(data, EI=48883.18168985724)


LIMITS = {
    # a limit of two data that no cable attains, the first of them and what the message says
    ("rise", "bend_radius"): (lambda bend_radius: 4.0 * bend_radius, "less than 4 of its bend_radius"),
    ("rise", "force"): (lambda force: 2.0 * math.sqrt(40000.0 / force), r"less than 2 of its sqrt\(EI / force\)"),
    ("bend_radius", "force"): (
        lambda force: 0.5 * math.sqrt(40000.0 / force),
        r"more than 0.5 of its sqrt\(EI / force\)",
    ),
}


@pytest.mark.parametrize("pair", LIMITS)
@pytest.mark.parametrize("second", [0.25, 2.5, 10.0, 25.0, 100.0, 1600.0, 3.7, 1e-3])
def test_a_limit_that_no_cable_attains_is_refused(pair: tuple[str, str], second: float) -> None:
    limit, words = LIMITS[pair]
    at = limit(second)
    impossible = 1.0 if pair[0] == "rise" else -1.0
    for value in (at, math.nextafter(at, impossible * math.inf), at * (1.0 + impossible * 1e-9)):
        with pytest.raises(InfeasibleError, match=words):
            solve_pinned({pair[0]: value, pair[1]: second}, EI=40000.0)
    inside = {pair[0]: at * (1.0 - impossible * 1e-9), pair[1]: second}
    solved = solve_pinned(inside, EI=40000.0)
    assert math.degrees(solved.arch.angle) > 179.9
    for key, value in inside.items():
        assert solved.datum(key, EI=40000.0) == pytest.approx(value, rel=1e-12)


@given(st.sampled_from(list(LIMITS)), st.floats(-3.0, 3.0), st.integers(-40, 40))
@settings(max_examples=200, deadline=None)
def test_near_a_limit_data_are_met_or_refused(pair: tuple[str, str], log_second: float, ulps: int) -> None:
    second = 10.0**log_second
    first = LIMITS[pair][0](second)
    data = {pair[0]: first + ulps * math.ulp(first), pair[1]: second}
    try:
        solved = solve_pinned(data, EI=40000.0)
    except InfeasibleError:
        assert ulps >= -2 if pair[0] == "rise" else ulps <= 2
    else:
        for key, value in data.items():
            assert solved.datum(key, EI=40000.0) == pytest.approx(value, rel=1e-12)


def test_an_arch_that_does_not_meet_its_data_is_never_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pinned_data, "arches", lambda _data, _EI: [Arch.at(-300.0)])
    with pytest.raises(InfeasibleError, match="no cable pinned at both ends has both"):
        solve_pinned({"length": 350.0, "bend_radius": 100.0})


def test_contradiction_names_the_consistent_value() -> None:
    with pytest.raises(SceneError) as caught:
        solve_pinned({"length": 350.0, "angle_deg": 20.0, "chord": 300.0}, names={"chord": "end.position"})
    (mistake,) = caught.value.mistakes
    assert mistake.path == "angle_deg"
    assert mistake.value == 20.0
    assert "end.position = 300 mm" in mistake.problem
    exact = PinnedOracle(350.0, m=mp.findroot(lambda m: 2 * mp.ellipe(m) / mp.ellipk(m) - 1 - mp.mpf(300) / 350, 0.1))
    assert f"give {float(exact.data['angle_deg']):.9g} degrees" in mistake.problem


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 6.2e-5, 4.8e-6, 1.3e-6])
@pytest.mark.parametrize("key", ["angle_deg", "rise", "bend_radius"])
def test_a_third_datum_knows_more_of_a_nearly_straight_cable(key: str, angle: float) -> None:
    """The chord is the length but for its last digits; another datum has all of its own."""
    for length in (350.0, 1234.56789, 3.7e-3):
        exact = PinnedOracle(length, angle_deg=angle).data
        data = {name: float(exact[name]) for name in ("length", "chord", key)}
        if data["chord"] == data["length"]:
            continue
        solved = solve_pinned(data)
        noise = 2.3e-16 * length / (length - data["chord"])
        assert solved.datum("angle_deg") == pytest.approx(angle, rel=1e-12 if noise > 1e-6 else 1e-6)
        assert solved.chord == pytest.approx(data["chord"], rel=1e-15)
        for factor in (math.exp(2.0 * noise + 2e-6), math.exp(-2.0 * noise - 2e-6), 1e4, 1e-4):
            with pytest.raises(SceneError, match="contradicts"):
                solve_pinned(data | {key: data[key] * factor})


def test_a_third_datum_of_pins_far_from_the_origin() -> None:
    """There the rounding of positions is what the chord lacks."""
    exact = PinnedOracle(100.0, angle_deg=0.01).data
    chord = float(exact["chord"])
    for start in (0.0, 1e3, 1e5):
        ends = Pin((start, 0, 0)), Pin((start + chord, 0, 0))
        found = solve_rod(Cable("c", 1.0, *ends, length=100.0, angle_deg=0.01))
        assert found.end_angle_deg == pytest.approx(0.01, rel=1e-5)
        assert found.residual < 1e-12
        with pytest.raises(SceneError, match="contradicts"):
            solve_rod(Cable("c", 1.0, *ends, length=100.0, angle_deg=0.02))


def test_numbers_that_nine_digits_do_not_tell_apart_are_shown_with_more() -> None:
    with pytest.raises(SceneError, match=r"contradicts chord = 99\.9999999999 mm and length = 100 mm"):
        solve_pinned({"length": 100.0, "chord": 99.9999999999, "angle_deg": 5.0})


def test_redundant_data_that_agree_pass_with_a_note() -> None:
    assert solve_pinned({"length": 350.0, "angle_deg": 20.0, "force": 3.999069}, EI=48883.18168985724).notes
    assert not solve_pinned({"length": 350.0, "angle_deg": 90.0, "rise": 350.0 * 0.38137988181}).other


@pytest.mark.parametrize("angle", [1e-6, 1e-3, 1.0, 45.0, 130.0, 179.9])
def test_energy(angle: float) -> None:
    """Against the integral of kappa^2 / 2 by mpmath."""
    oracle = PinnedOracle(1.0, angle_deg=angle)
    kappa = lambda s: 2 * oracle.k * oracle.omega * mp.ellipfun("cn", oracle.omega * s, m=oracle.m)
    exact = mp.quad(lambda s: kappa(s) ** 2, mp.linspace(0, 0.5, 9))  # twice half of it
    assert relative(Arch.of_angle(math.radians(angle)).energy_ratio, exact) < 1e-13


@pytest.mark.parametrize(
    ("ratio", "m1"),
    [
        (-0.5, "0.0050366121410131062330742286978708"),
        (-0.9, "6.7973668084663665855627884130725e-17"),
        (-0.99, "3.0642713547424091120317436458468e-173"),
    ],
)
def test_long_loops(ratio: float, m1: str) -> None:
    """Chords down to -0.99 of the length, where m1 is far below rounding of m (values found without these formulas)."""
    solved = solve_pinned({"length": 1.0, "chord": ratio})
    # A chord rounded to a double moves ln(m1) by |dK/dd| eps: relative to m1 that is up to 400 eps / (1 + d)^2.
    assert relative(solved.arch.m1, mp.mpf(m1)) < 1e-14 / (1.0 + ratio) ** 2
