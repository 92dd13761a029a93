"""Boundary representation: tubes as exact solids, what they are worth, and STEP in and out.

The only folder that imports Open Cascade (OCP), which takes about a second: import it late, inside the function that
needs it, and `kernel` before any other module: it says what to install where OCP is missing.
"""
