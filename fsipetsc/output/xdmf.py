"""NAME.xdmf beside the result NAME.h5 of a run in two dimensions: what ParaView and VTK open. It holds no numbers of its own.

A collection over time of collections of layers, each a curvilinear grid one point deep (3DSMesh of 1 by ny by nx points; with
a 2DSMesh, VTK's reader takes no vectors). The datasets (`file_layout`) have a row for each point, in which the columns of all
frames of the dataset stand one after the other, so everything is a HyperSlab: of positions two columns, x and y, of a field
one, of the velocity two. All is text that follows from names, shapes and columns: some 3 kB for each layer and frame.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from fsipetsc.errors import FileError
from fsipetsc.output.reader import BlockLayer, Run, open_run

_HEAD = '<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n<Xdmf Version="2.0">\n<Domain>\n'
_TAIL = "</Domain>\n</Xdmf>\n"
#: vectors made of columns that stand side by side
_VECTORS = {"velocity": ("u", "v", "w")}


def name_beside(path: str | os.PathLike[str]) -> Path:
    """NAME.xdmf for NAME.h5."""
    return Path(path).with_suffix(".xdmf")


def write(path: str | os.PathLike[str]) -> Path:
    """Write it beside a finished result of two dimensions; its path. FileError, OSError."""
    with open_run(path) as run:
        target = name_beside(run.path)
        draft = target.with_name(f".{target.name}.{os.getpid()}")
        try:
            with open(draft, "w", encoding="utf-8") as file:
                file.writelines(_text(run))
            os.replace(draft, target)  # who reads at the same time has one or the other
        finally:
            draft.unlink(missing_ok=True)
    return target


def earlier(result: Path) -> str | None:
    """The XDMF that stands beside a result, None if there is none. FileError if something else stands there; OSError."""
    target = name_beside(result)
    if not target.exists():
        return None
    text = target.read_text(encoding="utf-8", errors="replace") if target.is_file() else ""
    if not text.startswith(_HEAD):
        raise FileError(f"{target}: stands where the XDMF of {result.name} belongs, and is none; move it away")
    return text


def make_way(result: Path, kept_as: Path | None) -> None:
    """Let the XDMF of an earlier result go with it to its new name. FileError, OSError as of ``earlier``."""
    text = earlier(result)
    if text is None:
        return
    if kept_as is not None:
        own = text.replace(f">{escape(result.name)}:/", f">{escape(kept_as.name)}:/")
        name_beside(kept_as).write_text(own, encoding="utf-8")
    name_beside(result).unlink()


def _text(run: Run) -> Iterator[str]:
    file = escape(os.path.basename(run.path))
    yield _HEAD + f'<Grid Name={quoteattr(run.case)} GridType="Collection" CollectionType="Temporal">\n'
    for frame, t in enumerate(run.time):
        yield f'<Grid Name="frame {frame}" GridType="Collection" CollectionType="Spatial">\n<Time Value="{float(t)!r}"/>\n'
        for layer in run.layers:
            yield from _layer(layer, frame, file)
        yield "</Grid>\n"
    yield "</Grid>\n" + _TAIL


def _layer(layer: BlockLayer, frame: int, file: str) -> Iterator[str]:
    """One block in one frame."""
    dataset, first, shape = layer.place(frame)
    d, columns = len(layer.shape), layer.fields
    grid = " ".join(map(str, (1, *layer.shape) if d == 2 else layer.shape))

    def slab(names: Iterable[str]) -> str:
        """These columns, which stand side by side."""
        names = tuple(names)
        many = f" {len(names)}" if len(names) > 1 else ""
        begin = first + columns.index(names[0])
        return (
            f'<DataItem ItemType="HyperSlab" Dimensions="{grid}{many}" Type="HyperSlab">'
            f'<DataItem Dimensions="3 2" Format="XML">0 {begin} 1 1 {shape[0]} {len(names)}</DataItem>'
            f'<DataItem Dimensions="{shape[0]} {shape[1]}" NumberType="Float" Precision="8" Format="HDF">'
            f"{file}:{dataset}</DataItem></DataItem>"
        )

    yield f'<Grid Name={quoteattr(layer.name)} GridType="Uniform">\n'
    yield f'<Topology TopologyType="3DSMesh" Dimensions="{grid}"/>\n'
    yield f'<Geometry GeometryType="{"XYZ"[:d]}">{slab("xyz"[:d])}</Geometry>\n'
    for name in columns:
        if name not in "xyz"[:d]:
            yield f'<Attribute Name="{name}" AttributeType="Scalar" Center="Node">{slab((name,))}</Attribute>\n'
    for name, parts in _VECTORS.items():
        yield f'<Attribute Name="{name}" AttributeType="Vector" Center="Node">{slab(parts[:d])}</Attribute>\n'
    yield "</Grid>\n"
