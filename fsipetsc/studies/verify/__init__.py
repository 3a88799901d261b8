"""Cases with exact solutions and their references: the command `verify`.

The files of entries are ``coupled``, ``small_motions``, ``solids`` and ``gases``; see
fsipetsc.studies.verify.entry. The problem of each is in problems/NAME.md, exact enough to repeat it
in another code. The references in the folder `references` come from the independent programs in the
repository's folder `verify`.
"""
