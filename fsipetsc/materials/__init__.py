"""Laws of gases, transport and solids as formulas, one file each; Fluid and ElasticSolid."""

from fsipetsc.materials import formulas as formulas
