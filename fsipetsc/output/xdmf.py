"""NAME.xdmf beside the result of blocks in two or three dimensions, for ParaView and VTK.

It holds no numbers: a collection over time of collections of blocks, each a curvilinear grid, in
two dimensions one point deep (with a 2DSMesh, VTK's reader takes no vectors). The datasets have all
frames; a HyperSlab takes one of them.
"""

import os
from collections.abc import Iterator
from html import escape  # that of xml.sax loads all for the network

from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import beside, put
from fsipetsc.output.reader import Layer, Run

_HEAD = '<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="2.0">\n'


def write_xdmf(run: Run) -> None:
    """Write it beside a finished result. FileError if another file has the name; OSError."""
    target = beside(run.path, ".xdmf")
    if target.exists() and not target.read_text(errors="replace").startswith(_HEAD):
        raise FileError(f"{target}: is no XDMF of a result, and is left; {run.path} is complete")
    put(target, "".join(_xdmf(run)).encode())


def _xdmf(run: Run) -> Iterator[str]:
    file, name = escape(os.path.basename(run.path)), escape(run.case)
    yield _HEAD
    yield f'<Domain><Grid Name="{name}" GridType="Collection" CollectionType="Temporal">\n'
    for frame, t in enumerate(run.time):
        yield f'<Grid Name="frame {frame}" GridType="Collection" CollectionType="Spatial">\n'
        yield f'<Time Value="{float(t)!r}"/>\n'
        for k, layer in enumerate(run.layers):
            yield from _xdmf_block(layer, f"{file}:/layer{k}", frame, run.nframes)
        yield "</Grid>\n"
    yield "</Grid></Domain>\n</Xdmf>\n"


def _xdmf_block(layer: Layer, group: str, frame: int, nframes: int) -> Iterator[str]:
    d, shape = len(layer.shape), " ".join(map(str, layer.shape))
    grid = f"1 {shape}" if d == 2 else shape

    def slab(field: str) -> str:
        return (
            f'<DataItem ItemType="HyperSlab" Dimensions="{grid}">'
            f'<DataItem Dimensions="3 {d + 1}" Format="XML">'
            f"{frame}{' 0' * d} 1{' 1' * d} 1 {shape}</DataItem>"
            f'<DataItem Dimensions="{nframes} {shape}" NumberType="Float" Precision="8" '
            f'Format="HDF">{group}/{field}</DataItem></DataItem>'
        )

    def joined(fields: str) -> str:
        """Return vectors of these components."""
        function = ", ".join(f"${k}" for k in range(d))
        return (
            f'<DataItem ItemType="Function" Function="JOIN({function})" Dimensions="{grid} {d}">'
            f"{''.join(map(slab, fields[:d]))}</DataItem>"
        )

    yield f'<Grid Name="{escape(layer.name)}" GridType="Uniform">\n'
    yield f'<Topology TopologyType="3DSMesh" Dimensions="{grid}"/>\n'
    yield f'<Geometry GeometryType="{"XYZ"[:d]}">{joined("xyz")}</Geometry>\n'
    attribute = '<Attribute Name="{}" AttributeType="{}" Center="Node">{}</Attribute>\n'
    for name in layer.fields:
        if name not in "xyz"[:d]:
            yield attribute.format(name, "Scalar", slab(name))
    yield attribute.format("velocity", "Vector", joined("uvw"))
    yield "</Grid>\n"
