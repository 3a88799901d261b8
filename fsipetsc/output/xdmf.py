"""NAME.xdmf, by which ParaView and VTK read NAME.h5. It holds no numbers: a collection over time of
collections of blocks, each a curvilinear grid, in two dimensions one point deep (with a 2DSMesh,
VTK's reader takes no vectors). A HyperSlab takes one frame of a dataset.
"""

import os
from html import escape  # that of xml.sax loads all for the network

from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import beside, put
from fsipetsc.output.reader import Run

_BEGIN = b'<Xdmf Version="2.0"><!-- a result of fsipetsc -->'


def write_xdmf(run: Run) -> None:
    """Write NAME.xdmf beside a finished result. OSError; FileError over another file."""
    target = beside(run.path, ".xdmf")
    if target.exists() and not target.read_bytes().startswith(_BEGIN):
        raise FileError(f"{target}: is no XDMF of a result, and is left; {run.path} is complete")
    kind, frames = 'GridType="Collection" CollectionType', ""
    for frame, t in enumerate(run.time.tolist()):
        blocks = "".join(_block(run, k, frame) for k in range(len(run.layers)))
        about = f'Name="frame {frame}" {kind}="Spatial"'
        frames += f'<Grid {about}><Time Value="{t!r}"/>{blocks}</Grid>\n'
    series = f'<Grid Name="{escape(run.case)}" {kind}="Temporal">{frames}</Grid>'
    put(target, _BEGIN + f"<Domain>{series}</Domain></Xdmf>".encode())


def _block(run: Run, k: int, frame: int) -> str:
    layer, d, file = run.layers[k], run.dimension, escape(os.path.basename(run.path))
    shape, letters = " ".join(map(str, layer.shape)), "XYZ"[:d]
    size = f"1 {shape}" if d == 2 else shape

    def slab(field: str) -> str:
        return (
            f'<DataItem ItemType="HyperSlab" Dimensions="{size}">'
            f'<DataItem Dimensions="3 {d + 1}" Format="XML">'
            f"{frame}{' 0' * d} 1{' 1' * d} 1 {shape}</DataItem>"
            f'<DataItem Dimensions="{run.nframes} {shape}" NumberType="Float" Precision="8" '
            f'Format="HDF">{file}:/layer{k}/{field}</DataItem></DataItem>'
        )

    def vectors(fields: str) -> str:
        join = f'Function="JOIN({", ".join(f"${n}" for n in range(d))})"'
        slabs = "".join(map(slab, fields[:d]))
        return f'<DataItem ItemType="Function" {join} Dimensions="{size} {d}">{slabs}</DataItem>'

    known = {name: ("Scalar", slab(name)) for name in layer.fields if name not in "xyz"[:d]}
    known["velocity"] = "Vector", vectors("uvw")
    fields = "".join(
        f'<Attribute Name="{name}" AttributeType="{kind}" Center="Node">{data}</Attribute>'
        for name, (kind, data) in known.items()
    )
    return (
        f'<Grid Name="{escape(layer.name)}" GridType="Uniform">'
        f'<Topology TopologyType="3DSMesh" Dimensions="{size}"/>'
        f'<Geometry GeometryType="{letters}">{vectors("xyz")}</Geometry>{fields}</Grid>'
    )
