"""Results: written while a run goes on, read back, compared and drawn. (Without this file the site
would leave out the folder's public names.)
"""
