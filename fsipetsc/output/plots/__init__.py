"""Pictures of a result in one, two or three dimensions, films of it, and that of a
convergence study.

`fields` draws fields over space, and over space and time; `series` what is recorded at each step,
and what interfaces do; `page` puts them together and is what `plot` calls. Gas blue, solid red.
"""
