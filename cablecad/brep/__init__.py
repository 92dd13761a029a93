"""Boundary representation: tubes as exact solids, what they are worth, and STEP in and out.

The only folder that imports Open Cascade (OCP), which takes about a second: import it late, inside the function that
needs it. `kernel` comes before OCP in every module here, for it says what to install where OCP is missing.
"""
