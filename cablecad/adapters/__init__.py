"""cablecad as a guest in CAD scripts: `cablecad.adapters.cadquery` and `cablecad.adapters.build123d`.

Each imports its host, makes the host's own objects and patches nothing. What both share is in `ends` and `results`.
"""
