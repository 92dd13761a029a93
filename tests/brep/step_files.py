"""STEP files to read: written by Open Cascade's plain writer, and copies of files with some bytes changed."""

from cablecad.brep.kernel import interface_settings, silence


def write_plain(path, shapes, unit="MM"):
    """A root for each shape, no names given."""
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    with silence(), interface_settings({"write.step.unit": unit}):
        writer = STEPControl_Writer()
        for shape in shapes:
            writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
    return path


def cylinder(radius, height):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(radius, height).Shape()


def changed_copy(folder, source, *replacements):
    """A copy of a file with some bytes of it changed, each at the first place that has them."""
    data = source.read_bytes()
    for old, new in replacements:
        assert old in data
        data = data.replace(old, new, 1)
    path = folder / "changed.stp"
    path.write_bytes(data)
    return path
