"""NAME.xdmf beside the result of blocks in two or three dimensions, for ParaView and VTK.

It holds no numbers: a collection over time of collections of blocks, each a curvilinear grid, in
two dimensions one point deep (with a 2DSMesh, VTK's reader takes no vectors). The datasets have all
frames; a HyperSlab takes one of them.
"""

import os
from html import escape  # that of xml.sax loads all for the network

from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import beside, put
from fsipetsc.output.reader import Run

_HEAD = '<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="2.0">\n'
_SERIES = '<Domain><Grid Name="{}" GridType="Collection" CollectionType="Temporal">\n'
_FRAME = """<Grid Name="frame {}" GridType="Collection" CollectionType="Spatial">
<Time Value="{!r}"/>
"""
_BLOCK = """<Grid Name="{}" GridType="Uniform">
<Topology TopologyType="3DSMesh" Dimensions="{}"/>
<Geometry GeometryType="{}">{}</Geometry>
"""
_FIELD = '<Attribute Name="{}" AttributeType="{}" Center="Node">{}</Attribute>\n'


def write_xdmf(run: Run) -> None:
    """Write it beside a finished result. FileError if another file has the name; OSError."""
    target = beside(run.path, ".xdmf")
    if target.exists() and not target.read_text(errors="replace").startswith(_HEAD):
        raise FileError(f"{target}: is no XDMF of a result, and is left; {run.path} is complete")
    text = [_HEAD, _SERIES.format(escape(run.case))]
    for frame, t in enumerate(run.time.tolist()):
        text.append(_FRAME.format(frame, t))
        text += [_block(run, k, frame) for k in range(len(run.layers))]
        text.append("</Grid>\n")
    put(target, "".join([*text, "</Grid></Domain>\n</Xdmf>\n"]).encode())


def _block(run: Run, k: int, frame: int) -> str:
    layer, group = run.layers[k], f"{escape(os.path.basename(run.path))}:/layer{k}"
    d, shape = run.dimension, " ".join(map(str, layer.shape))
    grid = f"1 {shape}" if d == 2 else shape

    def slab(field: str) -> str:
        return (
            f'<DataItem ItemType="HyperSlab" Dimensions="{grid}">'
            f'<DataItem Dimensions="3 {d + 1}" Format="XML">'
            f"{frame}{' 0' * d} 1{' 1' * d} 1 {shape}</DataItem>"
            f'<DataItem Dimensions="{run.nframes} {shape}" NumberType="Float" Precision="8" '
            f'Format="HDF">{group}/{field}</DataItem></DataItem>'
        )

    def vectors(fields: str) -> str:
        function = ", ".join(f"${k}" for k in range(d))
        return (
            f'<DataItem ItemType="Function" Function="JOIN({function})" Dimensions="{grid} {d}">'
            f"{''.join(map(slab, fields[:d]))}</DataItem>"
        )

    names = (name for name in layer.fields if name not in "xyz"[:d])
    fields = [_FIELD.format(name, "Scalar", slab(name)) for name in names]
    fields.append(_FIELD.format("velocity", "Vector", vectors("uvw")))
    head = _BLOCK.format(escape(layer.name), grid, "XYZ"[:d], vectors("xyz"))
    return f"{head}{''.join(fields)}</Grid>\n"
