"""Objects of a scene, one file per family; `catalogue.KINDS` lists them all."""
