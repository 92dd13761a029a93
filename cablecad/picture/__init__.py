"""What people look at: shaded pictures of a scene by VTK, and plots of its cables by matplotlib.

`render` draws the picture, `plot` the plots. VTK and matplotlib are loaded only here, and only when something is drawn;
neither needs a display.
"""
