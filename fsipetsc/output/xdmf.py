"""NAME.xdmf beside the result NAME.h5 of blocks in two or three dimensions, for ParaView and VTK.

It holds no numbers: a collection over time of collections of blocks, each a curvilinear grid, in
two dimensions one point deep (3DSMesh of 1 by ny by nx points; with a 2DSMesh, VTK's reader takes
no vectors). The datasets have all frames (see `file_layout`); a HyperSlab takes one of them.
"""

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from fsipetsc.errors import FileError
from fsipetsc.output.file_layout import beside, put
from fsipetsc.output.reader import Layer, Run, open_run

_HEAD = '<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="2.0">\n'


def write(path: Path) -> None:
    """Write it beside a finished result. FileError if another file has the name; OSError."""
    target = beside(path, ".xdmf")
    if target.exists() and not target.read_text(errors="replace").startswith(_HEAD):
        raise FileError(f"{target}: is no XDMF of a result, and is left; {path} is complete")
    with open_run(path) as run:
        put(target, "".join(_text(run)).encode())


def move(path: Path, kept_as: Path) -> None:
    """Let the XDMF of an earlier result, if there is one, be that of its new name. OSError."""
    target = beside(path, ".xdmf")
    if target.is_file() and target.read_text(errors="replace").startswith(_HEAD):
        target.unlink()
        with suppress(FileError):  # it is damaged
            write(kept_as)


def _text(run: Run) -> Iterator[str]:
    file = escape(os.path.basename(run.path))
    name = quoteattr(run.case)
    yield _HEAD + f'<Domain><Grid Name={name} GridType="Collection" CollectionType="Temporal">\n'
    for frame, t in enumerate(run.time):
        yield f'<Grid Name="frame {frame}" GridType="Collection" CollectionType="Spatial">\n'
        yield f'<Time Value="{float(t)!r}"/>\n'
        for k, layer in enumerate(run.layers):
            yield from _layer(layer, f"{file}:/layer{k}", frame, run.nframes)
        yield "</Grid>\n"
    yield "</Grid></Domain>\n</Xdmf>\n"


def _layer(layer: Layer, group: str, frame: int, nframes: int) -> Iterator[str]:
    """One block in one frame."""
    d = len(layer.shape)
    whole = " ".join(map(str, (nframes, *layer.shape)))
    count = " ".join(map(str, (1, *layer.shape)))
    grid = count if d == 2 else " ".join(map(str, layer.shape))

    def slab(field: str) -> str:
        begin, stride = f"{frame}{' 0' * d}", f"1{' 1' * d}"
        return (
            f'<DataItem ItemType="HyperSlab" Dimensions="{grid}">'
            f'<DataItem Dimensions="3 {d + 1}" Format="XML">{begin} {stride} {count}</DataItem>'
            f'<DataItem Dimensions="{whole}" NumberType="Float" Precision="8" Format="HDF">'
            f"{group}/{field}</DataItem></DataItem>"
        )

    def joined(fields: str) -> str:
        """Vectors of these components."""
        function = ", ".join(f"${k}" for k in range(d))
        return (
            f'<DataItem ItemType="Function" Function="JOIN({function})" Dimensions="{grid} {d}">'
            f"{''.join(map(slab, fields[:d]))}</DataItem>"
        )

    yield f'<Grid Name={quoteattr(layer.name)} GridType="Uniform">\n'
    yield f'<Topology TopologyType="3DSMesh" Dimensions="{grid}"/>\n'
    yield f'<Geometry GeometryType="{"XYZ"[:d]}">{joined("xyz")}</Geometry>\n'
    attribute = '<Attribute Name="{}" AttributeType="{}" Center="Node">{}</Attribute>\n'
    for name in layer.fields:
        if name not in "xyz"[:d]:
            yield attribute.format(name, "Scalar", slab(name))
    yield attribute.format("velocity", "Vector", joined("uvw"))
    yield "</Grid>\n"
