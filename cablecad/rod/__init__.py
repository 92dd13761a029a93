"""Mechanics of the rod: the shape a cable takes, from its ends and its length. Knows nothing of CAD.

From the bottom up: `elliptic` has the functions all closed forms are made of, `quadrature` the same integrals by
Gauss-Legendre as an independent check; on them stand the elastica, the two-point problems, the choice of the model and
`solution`, which carries the result.
"""
