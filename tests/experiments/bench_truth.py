"""Makes the truth `cablecad bench` measures errors against: ``python bench_truth.py``, half a minute.

Written into cablecad/bench/truth/: a user of the command needs no mpmath. Everything is computed at 50 digits by
mpmath's own functions and written with 20; nothing of cablecad takes part.

points.json   The pinned elastica, u from 0 to K: x = 2 E(u) - u and y = 2 k cn(u), for each m1. u are doubles, exactly.
arches.json   The same for the tubes: x, y, the tangent's angle psi from the chord and its slope by u, 257 of u/K.
functions.json  Single values where functions of scipy fail; parameters are doubles, exactly.
planar.json   Of the reference table of planar scenes those with two clamps and one shape of least energy, scaled to
              length 1 and EI 1, the start at the origin.
"""

import json
from pathlib import Path

import mpmath as mp
import numpy as np

mp.mp.dps = 50

HERE = Path(__file__).parent
OUT = HERE.parents[1] / "cablecad" / "bench" / "truth"
TABLE = HERE.parent / "data" / "planar_reference.json"

PARAMETERS = ("0.9", "0.5", "0.19", "1e-1", "1e-2", "1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-14", "1e-16")
MODULI = ("0.342", "0.8", "0.999")
POINTS, NODES = 129, 257


def digits(value, count=20):
    return mp.nstr(value, count, strip_zeros=True)


def at(u, m):
    """x, y, psi and its slope at the argument u in [0, K]."""
    k = mp.sqrt(m)
    phi = mp.asin(min(mp.ellipfun("sn", u, m=m), mp.mpf(1)))
    cn = mp.ellipfun("cn", u, m=m)
    return 2 * mp.ellipe(phi, m) - u, 2 * k * cn, 2 * mp.asin(k * mp.sin(phi)), 2 * k * cn


def points():
    rows = []
    for text in PARAMETERS:
        m = 1 - mp.mpf(float(text))  # of the double, which is what is asked for
        quarter = mp.ellipk(m)
        places = np.linspace(0.0, float(quarter) * (1 - 1e-15), POINTS)
        found = [at(mp.mpf(u), m) for u in places.tolist()]
        x, y = ([digits(row[i]) for row in found] for i in range(2))
        rows.append({"m1": text, "K": digits(quarter), "u": [repr(u) for u in places.tolist()], "x": x, "y": y})
    return rows


def arches():
    rows = []
    for text in MODULI:
        m = mp.mpf(float(text)) ** 2
        quarter = mp.ellipk(m)
        found = [at(quarter * i / (NODES - 1), m) for i in range(NODES)]
        columns = {key: [digits(row[j]) for row in found] for j, key in enumerate(("x", "y", "psi", "slope"))}
        rows.append({"k": text, "K": digits(quarter)} | columns)
    return rows


def functions():
    """Name, arguments, value."""
    rows = []

    def add(name, u, m1, value):
        rows.append({"name": name, "u": u, "m1": m1, "value": digits(value)})

    for m1, share in (("1e-10", 1.5), ("1e-16", 1.5), ("1e-30", 2.5)):
        m = 1 - mp.mpf(float(m1))
        u = round(float(mp.ellipk(m)) * share, 3)
        # Beyond K the amplitude goes on: am(u) = pi - asin(sn) up to 3 K.
        phi = mp.pi - mp.asin(mp.ellipfun("sn", mp.mpf(u), m=m))
        add("cn", repr(u), m1, mp.ellipfun("cn", mp.mpf(u), m=m))
        add("E(u)", repr(u), m1, mp.ellipe(phi, m))
    for phi, m in (("0.5152081237009323", "0.81"), ("-0.5738414555877284", "0.9")):
        add("E(phi)", phi, repr(1.0 - float(m)), mp.ellipe(mp.mpf(float(phi)), mp.mpf(float(m))))
    add("cn", "400.0", "0.0", mp.sech(400))
    for m in ("1e-12", "1e-6"):
        value = mp.mpf(float(m))
        add("K - E", m, repr(1.0 - float(m)), mp.ellipk(value) - mp.ellipe(value))
    return rows


def planar():
    rows = []
    for row in json.loads(TABLE.read_text())["planar"]:
        if row["bc"] != "clamped-clamped" or row["n_equal_energy_minima"] != 1:
            continue
        length, EI = mp.mpf(row["L"]), mp.mpf(row["EI"])
        start = [mp.mpf(value) for value in row["start"]]

        def local(place, start=start, length=length):
            return [digits((mp.mpf(value) - zero) / length) for value, zero in zip(place, start, strict=True)]

        rows.append(
            {
                "name": row["name"],
                "start_angle": row["start_angle"],
                "end_angle": row["end_angle"],
                "end": local(row["end"]),
                "energy": digits(mp.mpf(row["energy"]) * length / EI),
                "points": [local(place) for place in row["points"]],
            }
        )
    return rows


def main():
    OUT.mkdir(exist_ok=True)
    for name, make in (("points", points), ("arches", arches), ("functions", functions), ("planar", planar)):
        text = json.dumps(make()).replace("], ", "],\n").replace("}, ", "},\n")
        (OUT / f"{name}.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
