"""Laws of gases, transport and solids as formulas, one file each; Fluid and ElasticSolid."""
