"""Pictures of a result, films of it, and that of a convergence study. Gas blue, solid red."""
