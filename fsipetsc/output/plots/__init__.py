"""Pictures of a result in one, two or three dimensions, films of it, and pictures of studies.

`fields` draws fields over space, `space_time` those of one dimension over x and t, and what
interfaces do, `series` what is recorded at each step; `page` puts them together, `command` is what
a user calls. Gas blue, solid red.
"""
